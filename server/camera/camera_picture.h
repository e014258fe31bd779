#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "server/clock.h"

namespace faultlab::server {

/// One picture of a bench, shared by all who look at it.
struct CameraPicture {
  std::string bytes;              ///< a whole JPEG or PNG file
  std::string_view content_type;  ///< "image/jpeg" or "image/png"
  MonotonicTime asked{};          ///< when the camera was asked; its frame may be a little older
  MonotonicTime arrived{};
};

using SharedPicture = std::shared_ptr<const CameraPicture>;

/// The content type of a picture by its first bytes; empty if it is neither JPEG nor PNG.
std::string_view PictureType(std::string_view bytes);

}  // namespace faultlab::server
