#include "server/web/json/message.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace procgen::web {
namespace {

constexpr size_t kTextLengthMax = 128;
constexpr size_t kShownTextMax = 40;  // of a given value in an error message
constexpr size_t kLengthBytes = 4;    // length field before the header of a binary message

// Serializes `json`; replaces invalid UTF-8, as texts may be cut within a character.
std::string TextOf(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// A short form of a given value for error messages; only the type of a list or an object.
std::string Shown(const Json& value) {
  if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    return text.size() > kShownTextMax ? absl::StrCat("a text of ", text.size(), " bytes")
                                       : absl::StrCat("'", text, "'");
  }
  return value.is_structured() ? value.type_name() : TextOf(value);
}

absl::StatusOr<Json> ParseObject(absl::string_view text) {
  if (text.size() > kHeaderBytesMax) {
    return absl::InvalidArgumentError(
        absl::StrCat("the JSON has ", text.size(), " bytes, allowed: at most ", kHeaderBytesMax));
  }
  Json json = Json::parse(text.begin(), text.end(), nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) {
    return absl::InvalidArgumentError("the message is not a JSON object");
  }
  return json;
}

// Reads an integer member. Returns false if it is missing or invalid.
bool TakeInteger(const Json& object, const char* name, int64_t max, int64_t* value) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_number_integer()) {
    return false;
  }
  if (found->is_number_unsigned() && found->get<uint64_t>() > static_cast<uint64_t>(max)) {
    return false;
  }
  *value = found->get<int64_t>();
  return *value >= 0;
}

bool TakeText(const Json& object, const char* name, std::string* value) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_string()) {
    return false;
  }
  *value = found->get_ref<const std::string&>();
  return value->size() <= kTextLengthMax;
}

absl::StatusOr<std::vector<Part>> TakeParts(const Json& list, absl::string_view rest) {
  if (!list.is_array() || list.size() > kPartCountMax) {
    return absl::InvalidArgumentError(
        absl::StrCat("parts is not a list of at most ", kPartCountMax, " entries"));
  }
  std::vector<Part> parts;
  for (const Json& entry : list) {
    Part& part = parts.emplace_back();
    int64_t size = 0;
    if (!entry.is_object() || !TakeText(entry, "name", &part.name) ||
        !TakeText(entry, "format", &part.format) ||
        !TakeInteger(entry, "bytes", kMessageBytesMax, &size) ||
        static_cast<size_t>(size) > rest.size()) {
      return absl::InvalidArgumentError(
          "an entry of parts needs a name, a format and a number of bytes that the message "
          "contains");
    }
    part.bytes = std::string(rest.substr(0, static_cast<size_t>(size)));
    rest.remove_prefix(part.bytes.size());
  }
  if (!rest.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("the message has ", rest.size(), " bytes more than its parts"));
  }
  return parts;
}

WireMessage Encode(Json header, const std::vector<Part>& parts) {
  if (parts.empty()) {
    return {TextOf(header), false};
  }
  Json& list = header["parts"] = Json::array();
  size_t size = 0;
  for (const Part& part : parts) {
    Json& entry = list.emplace_back(part.more);
    entry["name"] = part.name;
    entry["format"] = part.format;
    entry["bytes"] = part.bytes.size();
    size += part.bytes.size();
  }
  const std::string text = TextOf(header);
  WireMessage message{"", true};
  message.bytes.reserve(kLengthBytes + text.size() + size);
  for (size_t i = 0; i < kLengthBytes; ++i) {
    message.bytes.push_back(static_cast<char>(text.size() >> (8 * i)));
  }
  message.bytes += text;
  for (const Part& part : parts) {
    message.bytes += part.bytes;
  }
  return message;
}

}  // namespace

absl::StatusOr<Request> ParseRequest(absl::string_view bytes, bool is_binary) {
  absl::string_view rest;
  if (is_binary) {
    uint32_t length = 0;
    for (size_t i = 0; i < std::min(bytes.size(), kLengthBytes); ++i) {
      length |= uint32_t{static_cast<uint8_t>(bytes[i])} << (8 * i);
    }
    if (bytes.size() < kLengthBytes || length > bytes.size() - kLengthBytes) {
      return absl::InvalidArgumentError("the message is shorter than the header that it announces");
    }
    rest = bytes.substr(kLengthBytes + length);
    bytes = bytes.substr(kLengthBytes, length);
  }
  absl::StatusOr<Json> json = ParseObject(bytes);
  if (!json.ok()) {
    return json.status();
  }
  Request request;
  if (!TakeInteger(*json, "id", kIdMax, &request.id)) {
    return absl::InvalidArgumentError(
        absl::StrCat("id is not an integer from 0 to ", kIdMax, ", which every request needs"));
  }
  if (!TakeText(*json, "method", &request.method)) {
    return absl::InvalidArgumentError("method is not a text, which every request needs");
  }
  if (is_binary) {
    const auto list = json->find("parts");
    absl::StatusOr<std::vector<Part>> parts =
        TakeParts(list == json->end() ? Json::array() : *list, rest);
    if (!parts.ok()) {
      return parts.status();
    }
    request.parts = *std::move(parts);
    json->erase("parts");
  }
  json->erase("id");
  json->erase("method");
  request.members = *std::move(json);
  return request;
}

WireMessage EncodeAnswer(int64_t id, const absl::StatusOr<Answer>& answer) {
  if (!answer.ok()) {
    return Encode({{"id", id},
                   {"error",
                    {{"code", absl::StatusCodeToString(answer.status().code())},
                     {"message", std::string(answer.status().message())}}}},
                  {});
  }
  return Encode({{"id", id}, {"result", answer->result}}, answer->parts);
}

WireMessage EncodeEvent(Json header, const std::vector<Part>& parts) {
  return Encode(std::move(header), parts);
}

Json EndedEvent(const char* event, const absl::Status& status) {
  return {{"event", event},
          {"code", absl::StatusCodeToString(status.code())},
          {"message", std::string(status.message())}};
}

bool RequestParams::Has(const std::string& name) {
  known_.push_back(name);
  return members_.contains(name);
}

const Json* RequestParams::Find(const std::string& name) {
  known_.push_back(name);
  const auto found = members_.find(name);
  if (found == members_.end()) {
    Refuse(absl::StrCat(name, " is missing"));
    return nullptr;
  }
  return &*found;
}

int64_t RequestParams::Integer(const std::string& name, int64_t min, int64_t max) {
  const Json* const value = Find(name);
  if (value == nullptr) {
    return min;
  }
  const bool is_in_range =
      value->is_number_integer() &&
      !(value->is_number_unsigned() && value->get<uint64_t>() > static_cast<uint64_t>(INT64_MAX)) &&
      value->get<int64_t>() >= min && value->get<int64_t>() <= max;
  if (!is_in_range) {
    Refuse(
        absl::StrCat(name, " is ", Shown(*value), ", allowed: integers from ", min, " to ", max));
    return min;
  }
  return value->get<int64_t>();
}

double RequestParams::NumberOr(const std::string& name, double otherwise, double min, double max) {
  if (!Has(name)) {
    return otherwise;
  }
  const Json& value = members_.at(name);
  if (!value.is_number() || value.get<double>() < min || value.get<double>() > max) {
    Refuse(absl::StrCat(name, " is ", Shown(value), ", allowed: numbers from ", min, " to ", max));
    return otherwise;
  }
  return value.get<double>();
}

bool RequestParams::BooleanOr(const std::string& name, bool otherwise) {
  if (!Has(name)) {
    return otherwise;
  }
  const Json& value = members_.at(name);
  if (!value.is_boolean()) {
    Refuse(absl::StrCat(name, " is ", Shown(value), ", allowed: true, false"));
    return otherwise;
  }
  return value.get<bool>();
}

std::string RequestParams::Text(const std::string& name) {
  const Json* const value = Find(name);
  if (value == nullptr) {
    return "";
  }
  if (!value->is_string() || value->get_ref<const std::string&>().size() > kTextLengthMax) {
    Refuse(absl::StrCat(name, " is ", Shown(*value), ", allowed: a text of at most ",
                        kTextLengthMax, " bytes"));
    return "";
  }
  return value->get<std::string>();
}

std::string RequestParams::Choice(const std::string& name,
                                  const std::vector<std::string>& allowed) {
  const Json* const value = Find(name);
  if (value == nullptr) {
    return allowed.front();
  }
  if (!value->is_string() || std::find(allowed.begin(), allowed.end(),
                                       value->get_ref<const std::string&>()) == allowed.end()) {
    Refuse(absl::StrCat(name, " is ", Shown(*value), ", allowed: '", absl::StrJoin(allowed, "', '"),
                        "'"));
    return allowed.front();
  }
  return value->get<std::string>();
}

std::vector<int32_t> RequestParams::Integers(const std::string& name, size_t count_max,
                                             int32_t max) {
  const Json* const value = Find(name);
  if (value == nullptr) {
    return {};
  }
  std::vector<int32_t> integers;
  bool is_right = value->is_array() && !value->empty() && value->size() <= count_max;
  for (size_t i = 0; is_right && i < value->size(); ++i) {
    const Json& entry = value->at(i);
    is_right = entry.is_number_unsigned() && entry.get<uint64_t>() <= static_cast<uint64_t>(max);
    if (is_right) {
      integers.push_back(entry.get<int32_t>());
    }
  }
  if (!is_right) {
    Refuse(absl::StrCat(name, " is not a list of 1 to ", count_max, " integers from 0 to ", max));
  }
  return integers;
}

const Json& RequestParams::ObjectOr(const std::string& name) {
  static const Json& none = *new Json(Json::object());
  if (!Has(name)) {
    return none;
  }
  const Json& value = members_.at(name);
  if (!value.is_object()) {
    Refuse(absl::StrCat(name, " is ", Shown(value), ", allowed: an object"));
    return none;
  }
  return value;
}

void RequestParams::Refuse(absl::string_view message) {
  status_.Update(absl::InvalidArgumentError(message));
}

absl::Status RequestParams::CheckAll() {
  for (auto member = members_.begin(); status_.ok() && member != members_.end(); ++member) {
    if (std::find(known_.begin(), known_.end(), member.key()) == known_.end()) {
      Refuse(absl::StrCat(Shown(member.key()), " is no member of this request; its members: ",
                          known_.empty() ? "none" : absl::StrJoin(known_, ", ")));
    }
  }
  return status_;
}

}  // namespace procgen::web
