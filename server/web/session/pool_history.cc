#include "server/web/session/pool_history.h"

#include <algorithm>
#include <cmath>

#include "server/web/session/convert_json.h"

namespace procgen::web {
namespace {

// How the rows of an interval become one row.
enum class Combination : uint8_t { kMean, kLast, kMin, kMax };

struct Column {
  const char* name;
  Combination combination;
};

// Of Row::values.
constexpr std::array<Column, 9> kColumns = {{{"steps_per_second", Combination::kMean},
                                             {"episode_count", Combination::kLast},
                                             {"mean_return", Combination::kMean},
                                             {"mean_length", Combination::kMean},
                                             {"request_p50_ms", Combination::kMean},
                                             {"request_p99_ms", Combination::kMean},
                                             {"return_min", Combination::kMin},
                                             {"return_max", Combination::kMax},
                                             {"return_deviation", Combination::kMean}}};
constexpr size_t kStepsPerSecond = 0;
// Rows over which a rate is measured: learners that update their policy between rollouts step in
// bursts.
constexpr size_t kRateRows = 10;
constexpr size_t kMeanReturn = 2;
constexpr size_t kReturnMin = 6;

float ValueOf(const Json& json) {
  return json.is_null() ? std::numeric_limits<float>::quiet_NaN() : json.get<float>();
}

Json JsonOf(double value) { return std::isnan(value) ? Json() : Json(value); }

// Combines the values of an interval, without the missing ones.
class Combiner {
 public:
  explicit Combiner(Combination combination) : combination_(combination) {}

  void Add(float value) {
    if (std::isnan(value)) {
      return;
    }
    sum_ += static_cast<double>(value);
    min_ = count_ == 0 ? value : std::min(min_, value);
    max_ = count_ == 0 ? value : std::max(max_, value);
    last_ = value;
    ++count_;
  }
  // NaN without values.
  float Result() const {
    if (count_ == 0) {
      return std::numeric_limits<float>::quiet_NaN();
    }
    switch (combination_) {
      case Combination::kMean:
        return static_cast<float>(sum_ / count_);
      case Combination::kLast:
        return last_;
      case Combination::kMin:
        return min_;
      case Combination::kMax:
        return max_;
    }
    return last_;
  }

 private:
  const Combination combination_;
  double sum_ = 0;
  float min_ = 0;
  float max_ = 0;
  float last_ = 0;
  int32_t count_ = 0;
};

}  // namespace

void PoolHistory::Add(double time_s, const std::vector<PoolReport>& reports) {
  std::map<Key, Course> before = std::move(courses_);
  courses_.clear();
  for (const PoolReport& report : reports) {
    Course& course = courses_[KeyOf(report.pool)];
    const auto found = before.find(KeyOf(report.pool));
    if (found != before.end() &&
        found->second.create_time_s == SecondsOf(report.pool.create_time())) {
      course = std::move(found->second);
    }
    AddReport(time_s, report, &course);
  }
}

void PoolHistory::AddReport(double time_s, const PoolReport& report, Course* course) {
  const procgen::v1::Pool& pool = report.pool;
  Row row;
  row.time_s = time_s;
  row.step_count = static_cast<double>(pool.step_count());
  float steps_per_second = kNone;
  double step_count_before = 0;
  if (const std::deque<Row>& rows = course->series[0].rows; !rows.empty()) {
    step_count_before = rows.back().step_count;
    const Row& first = rows[rows.size() - std::min(rows.size(), kRateRows)];
    const double seconds = time_s - first.time_s;
    steps_per_second = seconds > 0
                           ? static_cast<float>((row.step_count - first.step_count) / seconds)
                           : rows.back().values[kStepsPerSecond];
  }
  if (row.step_count > step_count_before) {
    course->last_step_time_s = time_s;
  }
  const bool has_episodes = pool.episode_count() > 0;
  row.values = {steps_per_second,
                static_cast<float>(pool.episode_count()),
                ValueOf(MeanReturnJson(pool)),
                ValueOf(MeanLengthJson(pool)),
                ValueOf(RequestP50MsJson(pool)),
                ValueOf(RequestP99MsJson(pool)),
                has_episodes ? report.return_min : kNone,
                has_episodes ? report.return_max : kNone,
                has_episodes ? report.return_deviation : kNone};
  course->create_time_s = SecondsOf(pool.create_time());
  course->games.clear();
  for (const GameReturn& game : report.game_returns) {
    course->games.push_back(game.game);
    row.game_returns.push_back(game.mean_return);
  }
  AddRow(std::move(row), 0, course);
}

void PoolHistory::AddRow(Row row, size_t resolution, Course* course) {
  if (const size_t coarser = resolution + 1; coarser < kResolutions.size()) {
    std::vector<Row>& pending = course->series[coarser].pending;
    const int32_t interval_s = kResolutions[coarser].interval_s;
    const auto interval_of = [interval_s](const Row& of) {
      return static_cast<int64_t>(std::floor(of.time_s / interval_s));
    };
    if (!pending.empty() && interval_of(pending.front()) != interval_of(row)) {
      AddRow(Combine(pending), coarser, course);
      pending.clear();
    }
    pending.push_back(row);
  }
  std::deque<Row>& rows = course->series[resolution].rows;
  rows.push_back(std::move(row));
  if (rows.size() > kResolutions[resolution].rows_max) {
    rows.pop_front();
  }
}

PoolHistory::Row PoolHistory::Combine(const std::vector<Row>& rows) {
  Row combined = rows.back();
  for (size_t column = 0; column < kColumns.size(); ++column) {
    Combiner combiner(kColumns[column].combination);
    for (const Row& row : rows) {
      combiner.Add(row.values[column]);
    }
    combined.values[column] = combiner.Result();
  }
  for (size_t game = 0; game < combined.game_returns.size(); ++game) {
    Combiner combiner(Combination::kMean);
    for (const Row& row : rows) {
      combiner.Add(row.game_returns[game]);
    }
    combined.game_returns[game] = combiner.Result();
  }
  return combined;
}

const PoolHistory::Course* PoolHistory::Find(const procgen::v1::Pool& pool) const {
  const auto found = courses_.find(KeyOf(pool));
  return found != courses_.end() && found->second.create_time_s == SecondsOf(pool.create_time())
             ? &found->second
             : nullptr;
}

size_t PoolHistory::ResolutionFor(int32_t span_s) {
  size_t resolution = 0;
  while (resolution + 1 < kResolutions.size() &&
         static_cast<size_t>(span_s) > static_cast<size_t>(kResolutions[resolution].interval_s) *
                                           kResolutions[resolution].rows_max) {
    ++resolution;
  }
  return resolution;
}

std::vector<const PoolHistory::Row*> PoolHistory::SelectRows(const Course& course, int32_t span_s) {
  const size_t resolution = ResolutionFor(span_s);
  const double begin_s = course.series[0].rows.back().time_s - span_s;
  std::vector<const Row*> selected;
  const auto select = [begin_s, &selected](const auto& rows) {
    for (const Row& row : rows) {
      if (row.time_s > begin_s) {
        selected.push_back(&row);
      }
    }
  };
  select(course.series[resolution].rows);
  for (size_t finer = resolution; finer > 0; --finer) {
    select(course.series[finer].pending);
  }
  return selected;
}

Json PoolHistory::NewestOf(const procgen::v1::Pool& pool) const {
  const Course* const course = Find(pool);
  Row none;
  none.values.fill(kNone);
  const Row& row = course == nullptr ? none : course->series[0].rows.back();
  Json newest = {
      {kColumns[kStepsPerSecond].name, JsonOf(row.values[kStepsPerSecond])},
      {"last_step_time_s", course == nullptr ? Json() : JsonOf(course->last_step_time_s)}};
  for (size_t column = kReturnMin; column < kColumns.size(); ++column) {
    newest[kColumns[column].name] = JsonOf(row.values[column]);
  }
  newest["game_returns"] = Json::object();
  for (size_t game = 0; game < row.game_returns.size(); ++game) {
    newest["game_returns"][course->games[game]] = JsonOf(row.game_returns[game]);
  }
  return newest;
}

Json PoolHistory::RowsOf(const procgen::v1::Pool& pool, int32_t span_s) const {
  Json columns = {"time_s", "step_count"};
  for (const Column& column : kColumns) {
    columns.push_back(column.name);
  }
  Json games = Json::array();
  Json rows = Json::array();
  if (const Course* const course = Find(pool); course != nullptr) {
    games = course->games;
    for (const Row* row : SelectRows(*course, span_s)) {
      Json& json = rows.emplace_back(Json::array({row->time_s, row->step_count}));
      for (const float value : row->values) {
        json.push_back(JsonOf(value));
      }
      for (const float value : row->game_returns) {
        json.push_back(JsonOf(value));
      }
    }
  }
  return {{"pool", pool.name()},
          {"interval_s", kResolutions[ResolutionFor(span_s)].interval_s},
          {"columns", std::move(columns)},
          {"games", std::move(games)},
          {"rows", std::move(rows)}};
}

Json PoolHistory::ReturnsOf(const procgen::v1::Pool& pool, size_t count) const {
  constexpr int32_t kSpanS = 3600;
  Json returns = Json::array();
  const Course* const course = Find(pool);
  if (course == nullptr) {
    return returns;
  }
  const std::vector<const Row*> rows = SelectRows(*course, kSpanS);
  const size_t shown = std::min(count, rows.size());
  for (size_t i = 1; i <= shown; ++i) {
    returns.push_back(JsonOf(rows[i * rows.size() / shown - 1]->values[kMeanReturn]));
  }
  return returns;
}

}  // namespace procgen::web
