#include "hardware/lcm/sealed_message.h"

#include <sodium.h>

#include <algorithm>
#include <string_view>

#include "core/types/check.h"
#include "faultlab_msgs/rig_sealed_t.hpp"
#include "hardware/lcm/message_layout.h"

namespace faultlab::hardware {
namespace {

/// A sample with the events of a fault is as long as one without; the plan of many faults as long
/// as any command.
constexpr std::size_t kShortBlock = kShortMessageBytes + 1;  // sodium_pad() adds at least one
constexpr std::size_t kLongBlock = 4096;
constexpr std::size_t kNonceBytes = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES;
constexpr std::size_t kTagBytes = crypto_aead_xchacha20poly1305_ietf_ABYTES;
constexpr std::size_t kIntBytes = 4;
static_assert(sizeof faultlab_msgs::rig_sealed_t::nonce == kNonceBytes);

/// Where the parts of a sealed message of this rig lie.
struct Places {
  explicit Places(const std::string& rig)
      : protocol(kMessageHashBytes + kIntBytes + rig.size() + 1),
        nonce(protocol + kIntBytes),
        box(nonce + kNonceBytes + kIntBytes) {}
  std::size_t protocol;
  std::size_t nonce;
  std::size_t box;
};

std::size_t BlockOf(const std::string& channel, const std::string& rig, std::size_t size) {
  return size < kShortBlock && channel != CommandChannel(rig) ? kShortBlock : kLongBlock;
}

/// The rig's key itself is not used twice.
RigKey SealKey(const RigKey& key) {
  static constexpr std::string_view kPurpose = "faultlab sealed message";
  return ComputeMac(key, {reinterpret_cast<const std::uint8_t*>(kPurpose.data()), kPurpose.size()});
}

std::vector<std::uint8_t> AdditionalData(const std::string& channel,
                                         const std::string& rig,
                                         std::span<const std::uint8_t> head) {
  const std::string names = channel + " " + rig + " ";
  std::vector<std::uint8_t> data(names.begin(), names.end());
  data.insert(data.end(), head.begin(), head.end());
  return data;
}

}  // namespace

std::vector<std::uint8_t> SealBytes(std::span<const std::uint8_t> message,
                                    const std::string& channel,
                                    const std::string& rig,
                                    const RigKey& key,
                                    std::int32_t protocol) {
  const std::size_t block = BlockOf(channel, rig, message.size());
  std::vector<std::uint8_t> padded((message.size() / block + 1) * block);
  std::copy(message.begin(), message.end(), padded.begin());
  std::size_t padded_size = 0;
  LAB_CHECK(sodium_pad(&padded_size, padded.data(), message.size(), block, padded.size()) == 0);

  faultlab_msgs::rig_sealed_t sealed;
  sealed.rig = rig;
  sealed.protocol = protocol;
  randombytes_buf(sealed.nonce, sizeof sealed.nonce);
  sealed.box.resize(padded_size + kTagBytes);
  sealed.size = static_cast<std::int32_t>(sealed.box.size());
  std::vector<std::uint8_t> bytes = ToBytes(sealed);

  const Places at(rig);
  const auto data = AdditionalData(channel, rig, std::span(bytes).first(at.box));
  const RigKey seal_key = SealKey(key);
  crypto_aead_xchacha20poly1305_ietf_encrypt(bytes.data() + at.box,
                                             nullptr,
                                             padded.data(),
                                             padded_size,
                                             data.data(),
                                             data.size(),
                                             nullptr,
                                             bytes.data() + at.nonce,
                                             seal_key.data());
  return bytes;
}

std::optional<OpenedBytes> OpenSealed(std::span<const std::uint8_t> bytes,
                                      const std::string& channel,
                                      const std::string& rig,
                                      const RigKey& key) {
  const Places at(rig);
  if (bytes.size() < at.box + kTagBytes) return std::nullopt;
  const std::span<const std::uint8_t> box = bytes.subspan(at.box);
  const auto data = AdditionalData(channel, rig, bytes.first(at.box));
  const RigKey seal_key = SealKey(key);
  OpenedBytes opened;
  opened.message.resize(box.size() - kTagBytes);
  const bool ours = crypto_aead_xchacha20poly1305_ietf_decrypt(opened.message.data(),
                                                               nullptr,
                                                               nullptr,
                                                               box.data(),
                                                               box.size(),
                                                               data.data(),
                                                               data.size(),
                                                               bytes.data() + at.nonce,
                                                               seal_key.data()) == 0;
  const std::size_t padded = opened.message.size();
  std::size_t size = 0;
  if (!ours || padded == 0 || sodium_unpad(&size, opened.message.data(), padded, padded) != 0) {
    return std::nullopt;
  }
  opened.message.resize(size);
  std::uint32_t protocol = 0;
  for (std::size_t i = 0; i < kIntBytes; ++i) protocol = protocol << 8 | bytes[at.protocol + i];
  opened.protocol = static_cast<std::int32_t>(protocol);
  return opened;
}

std::optional<std::string> SealedRig(std::span<const std::uint8_t> bytes) {
  using Layout = LayoutOf<faultlab_msgs::rig_sealed_t>;
  static_assert(Layout::kFields[0].name == std::string_view("rig"));
  constexpr MessageLayout kNameOnly{.name = "rig", .fields = std::span(Layout::kFields).first(1)};
  if (bytes.size() < kMessageHashBytes) return std::nullopt;
  const std::span<const std::uint8_t> body = bytes.subspan(kMessageHashBytes);
  const std::optional<std::size_t> size = WalkMessage(kNameOnly, body);
  if (!size) return std::nullopt;
  const auto text = body.first(*size - 1).subspan(kIntBytes);
  return std::string(text.begin(), text.end());
}

}  // namespace faultlab::hardware
