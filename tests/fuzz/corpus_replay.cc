// Stands in for libFuzzer where the compiler has none: runs LLVMFuzzerTestOneInput on no bytes and
// on every file of the folders given. A crash or a sanitizer's complaint fails the test; the file
// is named.
//   TARGET CORPUS..
#include <unistd.h>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
/// There when the program was built with a sanitizer.
extern "C" __attribute__((weak)) void __sanitizer_set_death_callback(void (*callback)());

namespace {

std::string running;

void SayInput() {
  constexpr char kSays[] = "died on input ";
  (void)!write(STDERR_FILENO, kSays, sizeof kSays - 1);
  (void)!write(STDERR_FILENO, running.c_str(), running.size());
  (void)!write(STDERR_FILENO, "\n", 1);
}

void OnSignal(int number) {
  SayInput();
  std::signal(number, SIG_DFL);
  std::raise(number);
}

void Run(std::string name, const std::string& input) {
  running = std::move(name);
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

}  // namespace

int main(int argc, char** argv) {
  for (const int number : {SIGABRT, SIGSEGV, SIGFPE, SIGILL, SIGBUS}) {
    std::signal(number, OnSignal);
  }
  if (__sanitizer_set_death_callback != nullptr) __sanitizer_set_death_callback(SayInput);
  Run("(no bytes)", "");
  int inputs = 0;
  for (int i = 1; i < argc; ++i) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(argv[i])) {
      if (!entry.is_regular_file()) continue;
      std::ifstream in(entry.path(), std::ios::binary);
      Run(entry.path(), {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()});
      ++inputs;
    }
  }
  std::printf("%d inputs\n", inputs);
  return inputs > 0 ? 0 : 1;  // an empty corpus tests nothing
}
