#include "clients/python/native/native_client.h"

#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "clients/python/native/python_error.h"

namespace procgen_python {
namespace {

namespace py = pybind11;
namespace v1 = procgen::v1;
using procgen_client::Client;

// Largest message accepted from a faulty server. Attach.response_bytes_max bounds usual responses.
constexpr int32_t kResponseBytesMax = 256 << 20;

template <typename Message>
absl::StatusOr<std::string> Serialised(const absl::StatusOr<Message>& message) {
  return message.ok() ? absl::StatusOr<std::string>(message->SerializeAsString())
                      : message.status();
}

absl::StatusOr<std::string> Serialised(const absl::Status& status) {
  return status.ok() ? absl::StatusOr<std::string>("") : status;
}

// Returns a serialised Response with these elements.
template <typename Response, typename Element>
absl::StatusOr<std::string> SerialisedList(
    absl::StatusOr<std::vector<Element>> elements,
    google::protobuf::RepeatedPtrField<Element>* (Response::*field)()) {
  if (!elements.ok()) {
    return elements.status();
  }
  Response response;
  for (Element& element : *elements) {
    (response.*field)()->Add(std::move(element));
  }
  return response.SerializeAsString();
}

absl::StatusOr<std::string> SaveStates(Client* client, const v1::SaveStatesRequest& request) {
  return SerialisedList(
      client->SaveStates(request.pool(), request.environments(), request.response_bytes_max()),
      &v1::SaveStatesResponse::mutable_states);
}

absl::StatusOr<std::string> RestoreStates(Client* client, const v1::RestoreStatesRequest& request) {
  const std::vector<v1::State> states(request.states().begin(), request.states().end());
  return Serialised(client->RestoreStates(request.pool(), states));
}

absl::StatusOr<std::string> CloneStates(Client* client, const v1::CloneStatesRequest& request) {
  const std::vector<v1::ClonePair> pairs(request.pairs().begin(), request.pairs().end());
  return Serialised(client->CloneStates(
      request.pool(), pairs, {.pool = request.source_pool(), .server = request.source_server()}));
}

absl::StatusOr<std::string> RenewPool(Client* client, const v1::RenewPoolRequest& request) {
  std::optional<absl::Duration> lease;
  if (request.has_lease_duration()) {
    lease = absl::Seconds(request.lease_duration().seconds()) +
            absl::Nanoseconds(request.lease_duration().nanos());
  }
  return Serialised(client->RenewPool(request.name(), lease));
}

using Method =
    std::function<absl::StatusOr<std::string>(Client* client, const std::string& request)>;

// A Method that parses its argument as a Request.
template <typename Request, typename Function>
Method MethodOf(const Function& function) {
  return [function](Client* client, const std::string& serialised) -> absl::StatusOr<std::string> {
    Request request;
    if (!request.ParseFromString(serialised)) {
      return absl::InternalError("a request of this client is not a message");
    }
    return function(client, request);
  };
}

// The unary methods by their names in the API. Never destroyed.
const std::map<std::string, Method>& Methods() {
  static const auto* const methods = new std::map<std::string, Method>{
      {"GetCatalog", MethodOf<v1::GetCatalogRequest>([](Client* client, const auto& /*request*/) {
         return Serialised(client->GetCatalog());
       })},
      {"GetLoad", MethodOf<v1::GetLoadRequest>([](Client* client, const auto& /*request*/) {
         return Serialised(client->GetLoad());
       })},
      {"ListNodes", MethodOf<v1::ListNodesRequest>([](Client* client, const auto& /*request*/) {
         return Serialised(client->ListNodes());
       })},
      {"CreatePool", MethodOf<v1::CreatePoolRequest>([](Client* client, const auto& request) {
         return Serialised(client->CreatePool(request.spec(), request.pool_id()));
       })},
      {"GetPool", MethodOf<v1::GetPoolRequest>([](Client* client, const auto& request) {
         return Serialised(client->GetPool(request.name()));
       })},
      {"ListPools", MethodOf<v1::ListPoolsRequest>([](Client* client, const auto& /*request*/) {
         return SerialisedList(client->ListPools(), &v1::ListPoolsResponse::mutable_pools);
       })},
      {"DeletePool", MethodOf<v1::DeletePoolRequest>([](Client* client, const auto& request) {
         return Serialised(client->DeletePool(request.name()));
       })},
      {"RenewPool", MethodOf<v1::RenewPoolRequest>(RenewPool)},
      {"SaveStates", MethodOf<v1::SaveStatesRequest>(SaveStates)},
      {"RestoreStates", MethodOf<v1::RestoreStatesRequest>(RestoreStates)},
      {"CloneStates", MethodOf<v1::CloneStatesRequest>(CloneStates)},
      {"GetEpisode", MethodOf<v1::GetEpisodeRequest>([](Client* client, const auto& request) {
         return Serialised(
             request.fingerprint() == 0
                 ? client->GetEpisode(request.pool(), request.environment(), request.selector())
                 : client->FindEpisode(request.pool(), request.environment(),
                                       request.fingerprint()));
       })},
      {"RenderEnvironments",
       MethodOf<v1::RenderEnvironmentsRequest>([](Client* client, const auto& request) {
         return Serialised(client->RenderEnvironments(request.pool(), request.environments(),
                                                      request.size_px(), request.format(),
                                                      request.view()));
       })},
  };
  return *methods;
}

template <typename Watch>
std::unique_ptr<NativeWatch> WatchOf(const std::shared_ptr<Client>& client,
                                     std::unique_ptr<Watch> watch,
                                     std::shared_ptr<std::atomic<bool>> is_closed) {
  const std::shared_ptr<Watch> shared = std::move(watch);
  return std::make_unique<NativeWatch>([client, shared] { return Serialised(shared->Next()); },
                                       [client, shared] { shared->Stop(); }, std::move(is_closed));
}

}  // namespace

std::shared_ptr<NativeClient> NativeClient::Connect(const std::string& address,
                                                    std::optional<double> timeout,
                                                    double call_timeout,
                                                    procgen_client::Credentials credentials,
                                                    const ChannelArguments& channel_arguments) {
  std::shared_ptr<NativeClient> client(new NativeClient());
  procgen_client::ConnectOptions options;
  if (timeout.has_value()) {
    options.timeout = absl::Seconds(*timeout);
  }
  options.call_timeout = absl::Seconds(call_timeout);
  options.response_bytes_max = kResponseBytesMax;
  options.credentials = std::move(credentials);
  options.is_cancelled = [is_closed = client->is_closed_] {
    return *is_closed || SignalHandlerRaised();
  };
  for (const auto& [name, value] : channel_arguments) {
    if (const int* const number = std::get_if<int>(&value)) {
      options.channel_arguments.SetInt(name, *number);
    } else {
      options.channel_arguments.SetString(name, std::get<std::string>(value));
    }
  }
  client->client_ = ValueOf(WithoutGil([&] { return Client::Connect(address, options); }));
  return client;
}

NativeClient::~NativeClient() {
  if (!owner_.is_this_process()) {
    Leak(std::move(client_));
  }
}

std::shared_ptr<Client> NativeClient::client() const {
  if (client_ == nullptr) {
    Raise(absl::CancelledError("the connection was closed by this client"));
  }
  return client_;
}

py::bytes NativeClient::Call(const std::string& method, const py::bytes& request) {
  const std::string serialised = request;
  const auto client = this->client();
  return ValueOf(WithoutGil([&] { return Methods().at(method)(client.get(), serialised); }));
}

std::unique_ptr<NativeWatch> NativeClient::Watch(const std::string& method,
                                                 const py::bytes& request) {
  const auto client = this->client();
  if (method == "WatchNodes") {
    return WatchOf(client, client->WatchNodes(), is_closed_);
  }
  v1::WatchPoolRequest message;
  message.ParseFromString(std::string(request));
  return WatchOf(client, client->Watch(message), is_closed_);
}

std::shared_ptr<NativeStream> NativeClient::Attach(
    const py::bytes& attach, double reconnect_timeout,
    std::shared_ptr<procgen_client::HeldBatches> held_batches) {
  v1::Attach message;
  message.ParseFromString(std::string(attach));
  procgen_client::StreamOptions options;
  options.requests_in_flight_max = message.requests_in_flight_max();
  options.response_bytes_max = message.response_bytes_max();
  options.take_over = message.take_over();
  options.held_batches_max = message.held_batches_max();
  options.reconnect_timeout = absl::Seconds(reconnect_timeout);
  options.held_batches = std::move(held_batches);
  const auto client = this->client();
  std::shared_ptr<procgen_client::StepStream> attached =
      ValueOf(WithoutGil([&] { return client->Attach(message.pool(), options); }));
  auto stream = std::make_shared<NativeStream>(client, std::move(attached));
  std::erase_if(streams_, [](const auto& each) { return each.expired(); });
  streams_.push_back(stream);
  return stream;
}

void NativeClient::Close() {
  *is_closed_ = true;
  client_ = nullptr;
  for (const std::weak_ptr<NativeStream>& each : std::exchange(streams_, {})) {
    if (const std::shared_ptr<NativeStream> stream = each.lock()) {
      stream->Cancel();
    }
  }
}

}  // namespace procgen_python
