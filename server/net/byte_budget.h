#pragma once

#include <cstddef>
#include <optional>
#include <utility>

namespace faultlab::server {

/// How many bytes of all connections together may wait in memory for a peer: bodies that are not
/// read to their end, answers that are not sent to theirs. Of one thread.
class ByteBudget {
 public:
  explicit ByteBudget(std::size_t bytes_max) : bytes_max_(bytes_max) {}

  /// Bytes taken from the budget, given back at its end.
  class Hold {
   public:
    Hold() = default;
    Hold(ByteBudget& budget, std::size_t bytes) : budget_(&budget), bytes_(bytes) {}
    Hold(Hold&& other) noexcept
        : budget_(std::exchange(other.budget_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
    Hold& operator=(Hold&& other) noexcept {
      std::swap(budget_, other.budget_);
      std::swap(bytes_, other.bytes_);
      return *this;
    }
    ~Hold() {
      if (budget_ != nullptr) budget_->held_ -= bytes_;
    }
    std::size_t bytes() const { return bytes_; }
    /// Joins another hold of the same budget.
    void Add(Hold&& other) {
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

  /// Nothing when the budget has not so many left.
  std::optional<Hold> Take(std::size_t bytes) {
    if (bytes > bytes_max_ - held_) return std::nullopt;
    held_ += bytes;
    return Hold(*this, bytes);
  }
  std::size_t held() const { return held_; }

 private:
  const std::size_t bytes_max_;
  std::size_t held_ = 0;
};

}  // namespace faultlab::server
