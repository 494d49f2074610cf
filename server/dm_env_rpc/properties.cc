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

struct PropertyInfo {
  absl::string_view name;
  const char* description;
  dm::DataType type;
  Kind kind;
  bool is_of_world;         // false: of the server
  bool is_per_environment;  // in a batch, "NAME.I" is the property of environment I
  bool is_list;             // a value has shape [-1]; false: it is a scalar
  bool is_readable;
  bool is_writable;
};

constexpr PropertyInfo kProperties[] = {
    {"games", "Names of the games: the values of env_name.", dm::STRING, Kind::kGames, false, false,
     true, true, false},
    {"worlds", "Names of the worlds that can be joined.", dm::STRING, Kind::kWorlds, false, false,
     true, true, false},
    {"level_seed", "Seed of the current level.", dm::INT32, Kind::kLevelSeed, true, true, false,
     true, false},
    {"next_level_seed", "Seed of the next episode's level, in place of a drawn one.", dm::INT32,
     Kind::kNextLevelSeed, true, true, false, false, true},
    {"state", "Snapshot: the complete state. A written snapshot continues as the original would.",
     dm::UINT8, Kind::kState, true, true, true, true, true},
    {"step_count", "Environment steps since the world was created.", dm::INT64, Kind::kStepCount,
     true, false, false, true, false},
};

// A property by its key: of the server, of a whole world, or of one environment of a batch.
struct Property {
  const PropertyInfo* info = nullptr;
  std::optional<int32_t> environment = std::nullopt;
};

absl::Status NoSuchProperty(absl::string_view key) {
  return absl::NotFoundError(absl::StrCat("there is no property '", Truncated(key), "' here"));
}

absl::StatusOr<Property> FindProperty(absl::string_view key, const WorldSession* session) {
  const size_t dot = key.find('.');
  const absl::string_view name = key.substr(0, dot);
  const auto* const info =
      std::find_if(std::begin(kProperties), std::end(kProperties), [&](const PropertyInfo& known) {
        return known.name == name && (session != nullptr || !known.is_of_world);
      });
  if (info == std::end(kProperties)) {
    return NoSuchProperty(key);
  }
  if (dot == absl::string_view::npos) {
    return Property{info};
  }
  int32_t environment = 0;
  const absl::string_view index = key.substr(dot + 1);
  if (!info->is_per_environment || session->signature().is_single ||
      !absl::SimpleAtoi(index, &environment) || absl::StrCat(environment) != index ||
      environment < 0 || environment >= session->signature().env_count) {
    return NoSuchProperty(key);
  }
  return Property{info, environment};
}

// Whether it stands for the values of all environments of a batch.
bool IsOfBatch(const Property& property, const WorldSession* session) {
  return property.info->is_per_environment && !property.environment.has_value() &&
         !session->signature().is_single;
}

// False for all states of a batch: their lengths differ, so they are read and written one by one.
bool FitsOneTensor(const Property& property, const WorldSession* session) {
  return !(IsOfBatch(property, session) && property.info->is_list);
}

bool IsReadable(const Property& property, const WorldSession* session) {
  return property.info->is_readable && FitsOneTensor(property, session);
}

bool IsWritable(const Property& property, const WorldSession* session) {
  return property.info->is_writable && FitsOneTensor(property, session);
}

std::string KeyOf(const Property& property) {
  return property.environment.has_value()
             ? absl::StrCat(property.info->name, ".", *property.environment)
             : std::string(property.info->name);
}

absl::Status Forbidden(const Property& property, absl::string_view verb) {
  return absl::PermissionDeniedError(
      absl::StrCat("property '", KeyOf(property), "' cannot be ", verb));
}

void Describe(const Property& property, const WorldSession* session,
              dm_properties::PropertySpec* spec) {
  const PropertyInfo& info = *property.info;
  spec->mutable_spec()->set_name(KeyOf(property));
  spec->mutable_spec()->set_dtype(info.type);
  if (IsOfBatch(property, session)) {
    spec->mutable_spec()->add_shape(session->signature().env_count);
  }
  if (info.is_list) {
    spec->mutable_spec()->add_shape(TensorShape::kAnyLength);
  }
  spec->set_is_readable(IsReadable(property, session));
  spec->set_is_writable(IsWritable(property, session));
  spec->set_is_listable(IsOfBatch(property, session));
  spec->set_description(info.description);
}

absl::Status List(const std::string& key, const WorldSession* session,
                  dm_properties::ListPropertyResponse* response) {
  if (key.empty()) {
    for (const PropertyInfo& info : kProperties) {
      if (session != nullptr || !info.is_of_world) {
        Describe({&info}, session, response->add_values());
      }
    }
    return absl::OkStatus();
  }
  const absl::StatusOr<Property> property = FindProperty(key, session);
  if (!property.ok()) {
    return property.status();
  }
  if (!IsOfBatch(*property, session)) {
    return Forbidden(*property, "listed");
  }
  for (int32_t i = 0; i < session->signature().env_count; ++i) {
    Describe({property->info, i}, session, response->add_values());
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

void ReadLevelSeed(const Property& property, const WorldSession& session, dm::Tensor* value) {
  const std::vector<int32_t>& seeds = session.level_seeds();
  if (IsOfBatch(property, &session)) {
    value->mutable_int32s()->mutable_array()->Assign(seeds.begin(), seeds.end());
    value->add_shape(session.signature().env_count);
  } else {
    const auto environment = static_cast<size_t>(property.environment.value_or(0));
    value->mutable_int32s()->add_array(seeds[environment]);
  }
}

void ReadState(const Property& property, WorldSession* session, dm::Tensor* value,
               PoolSession::Done done) {
  session->SaveState(property.environment.value_or(0),
                     [value, done = std::move(done)](absl::StatusOr<std::string> snapshot) mutable {
                       const absl::Status status = snapshot.status();
                       if (status.ok()) {
                         value->add_shape(static_cast<int32_t>(snapshot->size()));
                         value->mutable_uint8s()->set_array(*std::move(snapshot));
                       }
                       done(status);
                     });
}

void ReadStepCount(const WorldSession& session, dm::Tensor* value, PoolSession::Done done) {
  session.world().InTurn(
      [value](PoolSession* pool, PoolSession::Done end) {
        value->mutable_int64s()->add_array(pool->step_count());
        end(absl::OkStatus());
      },
      std::move(done));
}

void Read(const PoolSupervisor& supervisor, absl::string_view owner, const std::string& key,
          WorldSession* session, dm::Tensor* value, PoolSession::Done done) {
  const absl::StatusOr<Property> property = FindProperty(key, session);
  if (!property.ok()) {
    done(property.status());
    return;
  }
  if (!IsReadable(*property, session)) {
    done(Forbidden(*property, "read"));
    return;
  }
  switch (property->info->kind) {
    case Kind::kGames:
      SetTexts(GameNames(), value);
      break;
    case Kind::kWorlds:
      SetTexts(WorldNames(supervisor, owner), value);
      break;
    case Kind::kLevelSeed:
      ReadLevelSeed(*property, *session, value);
      break;
    case Kind::kState:
      ReadState(*property, session, value, std::move(done));
      return;
    case Kind::kStepCount:
      ReadStepCount(*session, value, std::move(done));
      return;
    case Kind::kNextLevelSeed:
      break;
  }
  done(absl::OkStatus());
}

absl::Status WriteNextLevelSeed(const Property& property, const dm::Tensor& value,
                                WorldSession* session) {
  const bool is_of_batch = IsOfBatch(property, session);
  const absl::StatusOr<std::vector<int32_t>> seeds = ReadIntegersAsInt32s(
      KeyOf(property), value, is_of_batch ? session->signature().shape() : TensorShape::Scalar());
  if (!seeds.ok()) {
    return seeds.status();
  }
  for (size_t i = 0; i < seeds->size(); ++i) {
    const int32_t environment =
        is_of_batch ? static_cast<int32_t>(i) : property.environment.value_or(0);
    session->SetNextLevel(environment, (*seeds)[i]);
  }
  return absl::OkStatus();
}

void Write(const dm_properties::WritePropertyRequest& request, WorldSession* session,
           PoolSession::Done done) {
  const absl::StatusOr<Property> property = FindProperty(request.key(), session);
  if (!property.ok()) {
    done(property.status());
    return;
  }
  if (!IsWritable(*property, session)) {
    done(Forbidden(*property, "written"));
    return;
  }
  if (property->info->kind == Kind::kNextLevelSeed) {
    done(WriteNextLevelSeed(*property, request.value(), session));
    return;
  }
  const absl::StatusOr<absl::string_view> snapshot = ReadBytes(KeyOf(*property), request.value());
  if (!snapshot.ok()) {
    done(snapshot.status());
    return;
  }
  session->RestoreState(property->environment.value_or(0), *snapshot, std::move(done));
}

}  // namespace

void AnswerPropertyRequest(const PoolSupervisor& supervisor, absl::string_view owner,
                           WorldSession* session, const dm_properties::PropertyRequest& request,
                           dm_properties::PropertyResponse* response, PoolSession::Done done) {
  switch (request.payload_case()) {
    case dm_properties::PropertyRequest::kReadProperty:
      Read(supervisor, owner, request.read_property().key(), session,
           response->mutable_read_property()->mutable_value(), std::move(done));
      return;
    case dm_properties::PropertyRequest::kWriteProperty:
      response->mutable_write_property();
      Write(request.write_property(), session, std::move(done));
      return;
    case dm_properties::PropertyRequest::kListProperty:
      done(List(request.list_property().key(), session, response->mutable_list_property()));
      return;
    case dm_properties::PropertyRequest::PAYLOAD_NOT_SET:
      break;
  }
  done(absl::InvalidArgumentError(
      "the PropertyRequest is empty, allowed: read_property, write_property, "
      "list_property"));
}

}  // namespace procgen
