#pragma once

#include <cstddef>
#include <string>
#include <unordered_map>
#include <utility>

namespace faultlab::server {

/// Counts the places of each client. For use by one thread.
class ClientCounts {
 public:
  /// One place; its destructor gives it back.
  class Place {
   public:
    Place() = default;
    Place(Place&& other) noexcept
        : counts_(other.counts_), own_(std::exchange(other.own_, nullptr)) {}
    Place& operator=(Place&& other) noexcept {
      std::swap(counts_, other.counts_);
      std::swap(own_, other.own_);
      return *this;
    }
    ~Place() {
      if (own_ == nullptr) return;
      --counts_->all_;
      if (--own_->second > 0) return;
      counts_->of_.erase(counts_->of_.find(own_->first));
    }
    bool taken() const { return own_ != nullptr; }
    /// The number of places of its client; 0 if this place is not taken.
    std::size_t of_client() const { return own_ == nullptr ? 0 : own_->second; }

   private:
    friend class ClientCounts;
    Place(ClientCounts& counts, const std::string& client)
        : counts_(&counts), own_(&*counts.of_.try_emplace(client).first) {
      ++own_->second;
      ++counts.all_;
    }

    ClientCounts* counts_ = nullptr;
    std::pair<const std::string, std::size_t>* own_ = nullptr;  ///< map nodes do not move
  };

  Place Take(const std::string& client) { return {*this, client}; }
  std::size_t Of(const std::string& client) const {
    const auto own = of_.find(client);
    return own == of_.end() ? 0 : own->second;
  }
  std::size_t all() const { return all_; }

 private:
  std::size_t all_ = 0;
  std::unordered_map<std::string, std::size_t> of_;  ///< no entry is 0
};

}  // namespace faultlab::server
