#pragma once

#include <atomic>
#include <cstddef>
#include <optional>
#include <utility>

namespace faultlab::server {

/// Limits how many bytes of all connections together may wait in memory for a peer: bodies that are
/// not completely read, answers that are not completely sent. For use by one thread; only held()
/// may be called by others.
class ByteBudget {
 public:
  explicit ByteBudget(std::size_t bytes_max) : bytes_max_(bytes_max) {}

  /// Bytes taken from the budget; its destructor gives them back.
  class Reservation {
   public:
    Reservation() = default;
    Reservation(ByteBudget& budget, std::size_t bytes) : budget_(&budget), bytes_(bytes) {}
    Reservation(Reservation&& other) noexcept
        : budget_(std::exchange(other.budget_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
    Reservation& operator=(Reservation&& other) noexcept {
      std::swap(budget_, other.budget_);
      std::swap(bytes_, other.bytes_);
      return *this;
    }
    ~Reservation() {
      if (budget_ != nullptr) budget_->held_ -= bytes_;
    }
    std::size_t bytes() const { return bytes_; }
    /// Adds another hold of the same budget to this one.
    void Add(Reservation&& other) {
      if (budget_ == nullptr) {
        *this = std::move(other);
        return;
      }
      bytes_ += std::exchange(other.bytes_, 0);
      other.budget_ = nullptr;
    }

   private:
    ByteBudget* budget_ = nullptr;
    std::size_t bytes_ = 0;
  };

  /// Nothing when the budget has fewer bytes left.
  std::optional<Reservation> Take(std::size_t bytes) {
    if (bytes > bytes_max_ - held_) return std::nullopt;
    held_ += bytes;
    return Reservation(*this, bytes);
  }
  std::size_t held() const { return held_; }

 private:
  const std::size_t bytes_max_;
  std::atomic<std::size_t> held_{0};
};

}  // namespace faultlab::server
