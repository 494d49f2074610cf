#include "clients/libenv/art_folders.h"

#include <map>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace procgen {
namespace {

// Knows the art that handles draw with, and keeps none of it alive.
class ArtFolders {
 public:
  absl::StatusOr<std::shared_ptr<const SharedArt>> Find(const std::string& folder) {
    // Held while a folder is read: whoever wants the same one then finds it.
    absl::MutexLock lock(&mutex_);
    if (std::shared_ptr<const SharedArt> art = loaded_[folder].lock(); art != nullptr) {
      return art;
    }
    std::erase_if(loaded_, [](const auto& entry) { return entry.second.expired(); });
    auto art = SharedArt::LoadFolder(folder);
    if (art.ok()) {
      loaded_[folder] = *art;
    }
    return art;
  }

 private:
  absl::Mutex mutex_;
  std::map<std::string, std::weak_ptr<const SharedArt>> loaded_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

absl::StatusOr<std::shared_ptr<const SharedArt>> FindArt(const std::string& folder) {
  // Never destroyed: a host may end without closing its handles.
  static auto* const folders = new ArtFolders;
  if (folder.empty()) {
    return nullptr;
  }
  return folders->Find(folder);
}

}  // namespace procgen
