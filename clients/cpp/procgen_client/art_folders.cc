#include "procgen_client/art_folders.h"

#include <map>
#include <mutex>

namespace procgen_client {
namespace {

// Weak cache of the art that handles use.
class ArtFolders {
 public:
  procgen::StatusOr<std::shared_ptr<const procgen::SharedArt>> Find(const std::string& folder) {
    // Held while a folder is loaded, so that concurrent callers load it once.
    const std::lock_guard lock(mutex_);
    if (std::shared_ptr<const procgen::SharedArt> art = loaded_[folder].lock(); art != nullptr) {
      return art;
    }
    std::erase_if(loaded_, [](const auto& entry) { return entry.second.expired(); });
    auto art = procgen::SharedArt::LoadFolder(folder);
    if (art.ok()) {
      loaded_[folder] = *art;
    }
    return art;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<const procgen::SharedArt>> loaded_;  // under mutex_
};

}  // namespace

procgen::StatusOr<std::shared_ptr<const procgen::SharedArt>> FindArt(const std::string& folder) {
  // Never destroyed, because a host may exit without closing its handles.
  static auto* const folders = new ArtFolders;
  if (folder.empty()) {
    return nullptr;
  }
  return folders->Find(folder);
}

}  // namespace procgen_client
