#ifndef SERVER_WEB_PLAY_GALLERY_H_
#define SERVER_WEB_PLAY_GALLERY_H_

#include <cstdint>
#include <memory>

#include "absl/status/statusor.h"
#include "procgen_client/client.h"
#include "server/web/json/message.h"
#include "server/web/play/level_choice.h"

namespace procgen::web {

// Limits of a gallery page: levels, and image size in pixels.
inline constexpr int32_t kGalleryCountMax = 24;
inline constexpr int32_t kGallerySizePxMin = 64;
inline constexpr int32_t kGallerySizePxMax = 512;

// Renders the initial states of `count` levels with consecutive seeds, starting at `choice`, as PNG
// files. Blocks. Errors: those of the server.
absl::StatusOr<Answer> GalleryPage(const std::shared_ptr<procgen_client::Client>& client,
                                   const LevelChoice& choice, int32_t count, int32_t size_px,
                                   procgen::v1::FrameView view);

}  // namespace procgen::web

#endif  // SERVER_WEB_PLAY_GALLERY_H_
