#include "server/report/qr_code.h"

#include <qrencode.h>

#include <memory>

namespace faultlab::server {

std::optional<QrCode> MakeQrCode(const std::string& text) {
  constexpr int kSmallestVersion = 0;  // that holds the text
  const std::unique_ptr<QRcode, void (*)(QRcode*)> code(
      QRcode_encodeString8bit(text.c_str(), kSmallestVersion, QR_ECLEVEL_M), &QRcode_free);
  if (code == nullptr) return std::nullopt;
  QrCode out;
  out.width = code->width;
  const int squares = code->width * code->width;
  for (int i = 0; i < squares; ++i) out.dark.push_back((code->data[i] & 1U) != 0);
  return out;
}

}  // namespace faultlab::server
