#pragma once

#include <cstddef>
#include <string>
#include <unordered_map>
#include <utility>

namespace faultlab::server {

/// How many places each client holds. Of one thread.
class ClientCounts {
 public:
  /// One place, given back at its end.
  class Place {
   public:
    Place() = default;
    Place(Place&& other) noexcept
        : counts_(std::exchange(other.counts_, nullptr)), client_(std::move(other.client_)) {}
    Place& operator=(Place&& other) noexcept {
      std::swap(counts_, other.counts_);
      std::swap(client_, other.client_);
      return *this;
    }
    ~Place() {
      if (counts_ == nullptr) return;
      const auto own = counts_->of_.find(client_);
      if (--own->second == 0) counts_->of_.erase(own);
    }
    bool taken() const { return counts_ != nullptr; }
    const std::string& client() const { return client_; }

   private:
    friend class ClientCounts;
    Place(ClientCounts& counts, std::string client) : counts_(&counts), client_(std::move(client)) {
      ++counts_->of_[client_];
    }

    ClientCounts* counts_ = nullptr;
    std::string client_;
  };

  Place Take(std::string client) { return {*this, std::move(client)}; }
  std::size_t Of(const std::string& client) const {
    const auto own = of_.find(client);
    return own == of_.end() ? 0 : own->second;
  }

 private:
  std::unordered_map<std::string, std::size_t> of_;  ///< none is 0
};

}  // namespace faultlab::server
