#ifndef SERVER_CLUSTER_DDS_ENTITY_H_
#define SERVER_CLUSTER_DDS_ENTITY_H_

#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "dds/dds.h"

namespace procgen {

using DdsQos = std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)>;
inline DdsQos MakeQos() { return {dds_create_qos(), &dds_delete_qos}; }

// Owns an entity of Cyclone DDS; deletes it, and all entities created from it, on destruction.
class DdsEntity {
 public:
  DdsEntity() = default;
  ~DdsEntity() { Delete(); }
  DdsEntity(DdsEntity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  DdsEntity& operator=(DdsEntity&& other) noexcept {
    if (this != &other) {
      Delete();
      handle_ = std::exchange(other.handle_, 0);
    }
    return *this;
  }

  // Takes the result of a function of Cyclone DDS: an entity, or an error. `what`: its name for
  // errors.
  // Errors: FAILED_PRECONDITION.
  absl::Status Own(dds_entity_t handle, absl::string_view what) {
    if (handle < 0) {
      return absl::FailedPreconditionError(
          absl::StrCat("Cyclone DDS makes no ", what, ": ", dds_strretcode(handle)));
    }
    Delete();
    handle_ = handle;
    return absl::OkStatus();
  }

  dds_entity_t handle() const { return handle_; }

 private:
  void Delete() const {
    if (handle_ > 0) {
      dds_delete(handle_);
    }
  }

  dds_entity_t handle_ = 0;
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_DDS_ENTITY_H_
