#include "server/web/session/pool_history.h"

#include <cmath>
#include <limits>

#include "server/web/session/convert_json.h"

namespace procgen::web {
namespace {

// A missing value.
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

float ValueOf(const Json& json) { return json.is_null() ? kNone : json.get<float>(); }

Json JsonOf(float value) { return std::isnan(value) ? Json() : Json(value); }

}  // namespace

void PoolHistory::Add(double time_s, const std::vector<procgen::v1::Pool>& pools) {
  std::map<Key, Course> before = std::move(courses_);
  courses_.clear();
  for (const procgen::v1::Pool& pool : pools) {
    Course& course = courses_[KeyOf(pool)];
    const auto found = before.find(KeyOf(pool));
    if (found != before.end() && found->second.create_time_s == SecondsOf(pool.create_time())) {
      course = std::move(found->second);
    }
    AddRow(time_s, pool, &course);
  }
}

void PoolHistory::AddRow(double time_s, const procgen::v1::Pool& pool, Course* course) {
  const double seconds = time_s - course->time_s;
  if (!course->rows.empty() && seconds > 0) {
    course->steps_per_second =
        static_cast<double>(pool.step_count() - course->step_count) / seconds;
  }
  course->create_time_s = SecondsOf(pool.create_time());
  course->time_s = time_s;
  course->step_count = pool.step_count();
  course->times_s.push_back(time_s);
  course->rows.push_back({static_cast<float>(course->steps_per_second),
                          static_cast<float>(pool.episode_count()), ValueOf(MeanReturnJson(pool)),
                          ValueOf(MeanLengthJson(pool)), ValueOf(RequestP50MsJson(pool)),
                          ValueOf(RequestP99MsJson(pool))});
  if (course->rows.size() > kRowsMax) {
    course->rows.pop_front();
    course->times_s.pop_front();
  }
}

const PoolHistory::Course* PoolHistory::Find(const procgen::v1::Pool& pool) const {
  const auto found = courses_.find(KeyOf(pool));
  return found != courses_.end() && found->second.create_time_s == SecondsOf(pool.create_time())
             ? &found->second
             : nullptr;
}

double PoolHistory::StepsPerSecond(const procgen::v1::Pool& pool) const {
  const Course* const course = Find(pool);
  return course == nullptr ? 0 : course->steps_per_second;
}

Json PoolHistory::RowsOf(const procgen::v1::Pool& pool) const {
  Json rows = Json::array();
  if (const Course* const course = Find(pool); course != nullptr) {
    for (size_t i = 0; i < course->rows.size(); ++i) {
      Json& row = rows.emplace_back(Json::array({course->times_s[i]}));
      for (const float value : course->rows[i]) {
        row.push_back(JsonOf(value));
      }
    }
  }
  return {{"pool", pool.name()},
          {"interval_s", 1},
          {"columns",
           {"time_s", "steps_per_second", "episode_count", "mean_return", "mean_length",
            "request_p50_ms", "request_p99_ms"}},
          {"rows", std::move(rows)}};
}

}  // namespace procgen::web
