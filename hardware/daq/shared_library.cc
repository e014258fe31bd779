#include "hardware/daq/shared_library.h"

#include <dlfcn.h>

#include "hardware/io_error.h"

namespace faultlab::hardware {
namespace {

std::string LoaderText() {
  const char* text = dlerror();
  return text != nullptr ? text : "unknown reason";
}

}  // namespace

SharedLibrary::SharedLibrary(const std::string& path)
    : path_(path), handle_(dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL), [](void* handle) {
        if (handle != nullptr) dlclose(handle);
      }) {
  if (!handle_) throw IoError("the driver library does not load: " + LoaderText());
}

void* SharedLibrary::Address(const char* name) const {
  void* address = dlsym(handle_.get(), name);
  if (address == nullptr) throw IoError(path_ + " lacks " + name + ": " + LoaderText());
  return address;
}

}  // namespace faultlab::hardware
