#pragma once

#include <memory>
#include <string>

namespace faultlab::hardware {

/// A driver's library, loaded when a bench needs it: the program starts without any driver.
class SharedLibrary {
 public:
  /// Throws IoError that names the file and what the loader says.
  explicit SharedLibrary(const std::string& path);

  /// Throws IoError when the library lacks the function.
  template <typename Function>
  void Find(const char* name, Function*& function) const {
    function = reinterpret_cast<Function*>(Address(name));
  }

 private:
  void* Address(const char* name) const;

  std::string path_;
  std::shared_ptr<void> handle_;
};

}  // namespace faultlab::hardware
