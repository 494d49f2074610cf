#include "server/dm_env_rpc/properties.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

enum class Kind : uint8_t { kGames, kWorlds, kLevelSeed, kNextLevelSeed, kState, kStepCount };

struct PropertyFacts {
  absl::string_view name;
  const char* description;
  dm::DataType type;
  Kind kind;
  bool is_of_world;         // otherwise of the server
  bool is_per_environment;  // in a batch, "NAME.I" is that of environment I
  bool is_list;             // one value has shape [-1], otherwise it is a scalar
  bool is_readable;
  bool is_writable;
};

constexpr PropertyFacts kProperties[] = {
    {"games", "Names of the games, what a world's env_name may be.", dm::STRING, Kind::kGames,
     false, false, true, true, false},
    {"worlds", "Names of the worlds that can be joined.", dm::STRING, Kind::kWorlds, false, false,
     true, true, false},
    {"level_seed", "Seed of the level that is played.", dm::INT32, Kind::kLevelSeed, true, true,
     false, true, false},
    {"next_level_seed", "Seed of the level that is played next, in place of one drawn.", dm::INT32,
     Kind::kNextLevelSeed, true, true, false, false, true},
    {"state", "Snapshot: all that influences the future. What is written goes on as what was read.",
     dm::UINT8, Kind::kState, true, true, true, true, true},
    {"step_count", "Environment steps since the world was made.", dm::INT64, Kind::kStepCount, true,
     false, false, true, false},
};

// A property that was named: of the whole world, or of one environment of a batch.
struct Property {
  const PropertyFacts* facts = nullptr;
  std::optional<int32_t> environment = std::nullopt;
};

absl::Status NoSuchProperty(absl::string_view key) {
  return absl::NotFoundError(absl::StrCat("there is no property '", Shown(key), "' here"));
}

absl::StatusOr<Property> FindProperty(absl::string_view key, const WorldSession* play) {
  const size_t dot = key.find('.');
  const absl::string_view name = key.substr(0, dot);
  const auto* const facts =
      std::find_if(std::begin(kProperties), std::end(kProperties), [&](const PropertyFacts& known) {
        return known.name == name && (play != nullptr || !known.is_of_world);
      });
  if (facts == std::end(kProperties)) {
    return NoSuchProperty(key);
  }
  if (dot == absl::string_view::npos) {
    return Property{facts};
  }
  int32_t environment = 0;
  const absl::string_view index = key.substr(dot + 1);
  if (!facts->is_per_environment || play->form().is_single ||
      !absl::SimpleAtoi(index, &environment) || absl::StrCat(environment) != index ||
      environment < 0 || environment >= play->form().env_count) {
    return NoSuchProperty(key);
  }
  return Property{facts, environment};
}

// Whether it stands for those of a batch's environments.
bool IsOfBatch(const Property& property, const WorldSession* play) {
  return property.facts->is_per_environment && !property.environment.has_value() &&
         !play->form().is_single;
}

// A batch's states are read and written one by one, for they have lengths of their own.
bool IsWhole(const Property& property, const WorldSession* play) {
  return !(IsOfBatch(property, play) && property.facts->is_list);
}

bool IsReadable(const Property& property, const WorldSession* play) {
  return property.facts->is_readable && IsWhole(property, play);
}

bool IsWritable(const Property& property, const WorldSession* play) {
  return property.facts->is_writable && IsWhole(property, play);
}

std::string KeyOf(const Property& property) {
  return property.environment.has_value()
             ? absl::StrCat(property.facts->name, ".", *property.environment)
             : std::string(property.facts->name);
}

absl::Status Forbidden(const Property& property, absl::string_view verb) {
  return absl::PermissionDeniedError(
      absl::StrCat("property '", KeyOf(property), "' cannot be ", verb));
}

void Describe(const Property& property, const WorldSession* play,
              dm_properties::PropertySpec* spec) {
  const PropertyFacts& facts = *property.facts;
  spec->mutable_spec()->set_name(KeyOf(property));
  spec->mutable_spec()->set_dtype(facts.type);
  if (IsOfBatch(property, play)) {
    spec->mutable_spec()->add_shape(play->form().env_count);
  }
  if (facts.is_list) {
    spec->mutable_spec()->add_shape(TensorShape::kAnyLength);
  }
  spec->set_is_readable(IsReadable(property, play));
  spec->set_is_writable(IsWritable(property, play));
  spec->set_is_listable(IsOfBatch(property, play));
  spec->set_description(facts.description);
}

absl::Status List(const std::string& key, const WorldSession* play,
                  dm_properties::ListPropertyResponse* response) {
  if (key.empty()) {
    for (const PropertyFacts& facts : kProperties) {
      if (play != nullptr || !facts.is_of_world) {
        Describe({&facts}, play, response->add_values());
      }
    }
    return absl::OkStatus();
  }
  const absl::StatusOr<Property> property = FindProperty(key, play);
  if (!property.ok()) {
    return property.status();
  }
  if (!IsOfBatch(*property, play)) {
    return Forbidden(*property, "listed");
  }
  for (int32_t i = 0; i < play->form().env_count; ++i) {
    Describe({property->facts, i}, play, response->add_values());
  }
  return absl::OkStatus();
}

void SetTexts(const std::vector<std::string>& texts, dm::Tensor* value) {
  value->mutable_strings()->mutable_array()->Assign(texts.begin(), texts.end());
  value->add_shape(static_cast<int32_t>(texts.size()));
}

std::vector<std::string> GameNames() {
  std::vector<std::string> names;
  for (const GameSpec& game : GameCatalog()) {
    names.emplace_back(game.name);
  }
  return names;
}

std::vector<std::string> WorldNames(const PoolSupervisor& supervisor, absl::string_view owner) {
  std::vector<std::string> names;
  for (const PoolSupervisor::Numbered& world :
       supervisor.List(owner, 0, std::numeric_limits<size_t>::max())) {
    names.push_back(world.pool->name());
  }
  return names;
}

void ReadLevelSeed(const Property& property, const WorldSession& play, dm::Tensor* value) {
  const std::vector<int32_t>& seeds = play.level_seeds();
  if (IsOfBatch(property, &play)) {
    value->mutable_int32s()->mutable_array()->Assign(seeds.begin(), seeds.end());
    value->add_shape(play.form().env_count);
  } else {
    const auto environment = static_cast<size_t>(property.environment.value_or(0));
    value->mutable_int32s()->add_array(seeds[environment]);
  }
}

void ReadState(const Property& property, WorldSession* play, dm::Tensor* value,
               PoolSession::Done done) {
  play->SaveState(property.environment.value_or(0),
                  [value, done = std::move(done)](absl::StatusOr<std::string> snapshot) mutable {
                    const absl::Status status = snapshot.status();
                    if (status.ok()) {
                      value->add_shape(static_cast<int32_t>(snapshot->size()));
                      value->mutable_uint8s()->set_array(*std::move(snapshot));
                    }
                    done(status);
                  });
}

void ReadStepCount(const WorldSession& play, dm::Tensor* value, PoolSession::Done done) {
  play.world().InTurn(
      [value](PoolSession* pool, PoolSession::Done end) {
        value->mutable_int64s()->add_array(pool->step_count());
        end(absl::OkStatus());
      },
      std::move(done));
}

void Read(const PoolSupervisor& supervisor, absl::string_view owner, const std::string& key,
          WorldSession* play, dm::Tensor* value, PoolSession::Done done) {
  const absl::StatusOr<Property> property = FindProperty(key, play);
  if (!property.ok()) {
    done(property.status());
    return;
  }
  if (!IsReadable(*property, play)) {
    done(Forbidden(*property, "read"));
    return;
  }
  switch (property->facts->kind) {
    case Kind::kGames:
      SetTexts(GameNames(), value);
      break;
    case Kind::kWorlds:
      SetTexts(WorldNames(supervisor, owner), value);
      break;
    case Kind::kLevelSeed:
      ReadLevelSeed(*property, *play, value);
      break;
    case Kind::kState:
      ReadState(*property, play, value, std::move(done));
      return;
    case Kind::kStepCount:
      ReadStepCount(*play, value, std::move(done));
      return;
    case Kind::kNextLevelSeed:
      break;
  }
  done(absl::OkStatus());
}

absl::Status WriteNextLevelSeed(const Property& property, const dm::Tensor& value,
                                WorldSession* play) {
  const bool is_of_batch = IsOfBatch(property, play);
  const absl::StatusOr<std::vector<int32_t>> seeds = ReadIntegersAsInt32s(
      KeyOf(property), value, is_of_batch ? play->form().shape() : TensorShape::Scalar());
  if (!seeds.ok()) {
    return seeds.status();
  }
  for (size_t i = 0; i < seeds->size(); ++i) {
    const int32_t environment =
        is_of_batch ? static_cast<int32_t>(i) : property.environment.value_or(0);
    play->SetNextLevel(environment, (*seeds)[i]);
  }
  return absl::OkStatus();
}

void Write(const dm_properties::WritePropertyRequest& request, WorldSession* play,
           PoolSession::Done done) {
  const absl::StatusOr<Property> property = FindProperty(request.key(), play);
  if (!property.ok()) {
    done(property.status());
    return;
  }
  if (!IsWritable(*property, play)) {
    done(Forbidden(*property, "written"));
    return;
  }
  if (property->facts->kind == Kind::kNextLevelSeed) {
    done(WriteNextLevelSeed(*property, request.value(), play));
    return;
  }
  const absl::StatusOr<absl::string_view> snapshot = ReadBytes(KeyOf(*property), request.value());
  if (!snapshot.ok()) {
    done(snapshot.status());
    return;
  }
  play->RestoreState(property->environment.value_or(0), *snapshot, std::move(done));
}

}  // namespace

void AnswerPropertyRequest(const PoolSupervisor& supervisor, absl::string_view owner,
                           WorldSession* play, const dm_properties::PropertyRequest& request,
                           dm_properties::PropertyResponse* response, PoolSession::Done done) {
  switch (request.payload_case()) {
    case dm_properties::PropertyRequest::kReadProperty:
      Read(supervisor, owner, request.read_property().key(), play,
           response->mutable_read_property()->mutable_value(), std::move(done));
      return;
    case dm_properties::PropertyRequest::kWriteProperty:
      response->mutable_write_property();
      Write(request.write_property(), play, std::move(done));
      return;
    case dm_properties::PropertyRequest::kListProperty:
      done(List(request.list_property().key(), play, response->mutable_list_property()));
      return;
    case dm_properties::PropertyRequest::PAYLOAD_NOT_SET:
      break;
  }
  done(absl::InvalidArgumentError(
      "the PropertyRequest asks for nothing, allowed: read_property, write_property, "
      "list_property"));
}

}  // namespace procgen
