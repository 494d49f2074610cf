#include "clients/libenv/art_folders.h"

#include <map>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace procgen {
namespace {

// Weak cache of the art that handles use.
class ArtFolders {
 public:
  absl::StatusOr<std::shared_ptr<const SharedArt>> Find(const std::string& folder) {
    // Held while a folder is loaded, so that concurrent callers load it once.
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
  // Never destroyed, because a host may exit without closing its handles.
  static auto* const folders = new ArtFolders;
  if (folder.empty()) {
    return nullptr;
  }
  return folders->Find(folder);
}

}  // namespace procgen
