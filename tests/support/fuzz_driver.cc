// Stands in for libFuzzer where the compiler has none: runs LLVMFuzzerTestOneInput on every file of
// the corpus folders given, then on seeded mutations of them. A crash or a sanitizer's complaint
// fails the test; the input is left in ./crash-input.
//   target [-runs=N] [-seed=S] CORPUS..
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
/// There when the program was built with a sanitizer.
extern "C" __attribute__((weak)) void __sanitizer_set_death_callback(void (*callback)());

namespace {

constexpr std::size_t kBytesMax = 1 << 16;

const std::string* running = nullptr;

/// The input that was running when the program died.
void KeepCrashInput() {
  if (running != nullptr) std::ofstream("crash-input", std::ios::binary) << *running;
}

void OnSignal(int number) {
  KeepCrashInput();
  std::signal(number, SIG_DFL);
  std::raise(number);
}

void Run(const std::string& input) {
  running = &input;
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  running = nullptr;
}

std::vector<std::string> ReadCorpus(const std::vector<std::string>& folders) {
  std::vector<std::string> corpus = {""};
  for (const std::string& folder : folders) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      if (!entry.is_regular_file()) continue;
      std::ifstream in(entry.path(), std::ios::binary);
      corpus.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
  }
  return corpus;
}

class Mutator {
 public:
  Mutator(std::uint64_t seed, const std::vector<std::string>& corpus)
      : random_(seed), corpus_(corpus) {}

  std::string Next() {
    std::string text = Pick();
    const int edits = 1 + static_cast<int>(Below(6));
    for (int i = 0; i < edits; ++i) Edit(text);
    if (text.size() > kBytesMax) text.resize(kBytesMax);
    return text;
  }

 private:
  std::size_t Below(std::size_t bound) { return bound == 0 ? 0 : random_() % bound; }
  const std::string& Pick() { return corpus_[Below(corpus_.size())]; }

  void Edit(std::string& text) {
    static constexpr std::string_view kTokens[] = {
        "\"", "{", "}", "[", "]", ",", ":", "-", "1e999", "nan", "\\u0000", "\xff", "\r\n", "0x"};
    const std::size_t at = Below(text.size() + 1);
    switch (Below(7)) {
      case 0:
        if (!text.empty()) text[at % text.size()] = static_cast<char>(random_());
        break;
      case 1:
        text.insert(at, 1, static_cast<char>(random_()));
        break;
      case 2:
        text.erase(at, Below(16));
        break;
      case 3:
        text.insert(at, kTokens[Below(std::size(kTokens))]);
        break;
      case 4: {  // a piece of another input
        const std::string& other = Pick();
        const std::size_t from = Below(other.size());
        text.insert(at, other.substr(from, Below(64)));
        break;
      }
      case 5:
        text.insert(at, text.substr(Below(text.size()), Below(256)));
        break;
      default:
        if (!text.empty()) text[at % text.size()] ^= static_cast<char>(1 << Below(8));
    }
  }

  std::mt19937_64 random_;
  const std::vector<std::string>& corpus_;
};

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t runs = 20'000;
  std::uint64_t seed = 1;
  std::vector<std::string> folders;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument.starts_with("-runs=")) {
      runs = std::strtoull(argv[i] + 6, nullptr, 10);
    } else if (argument.starts_with("-seed=")) {
      seed = std::strtoull(argv[i] + 6, nullptr, 10);
    } else {
      folders.emplace_back(argument);
    }
  }
  for (const int number : {SIGABRT, SIGSEGV, SIGFPE, SIGILL, SIGBUS}) {
    std::signal(number, OnSignal);
  }
  if (__sanitizer_set_death_callback != nullptr) __sanitizer_set_death_callback(KeepCrashInput);
  const std::vector<std::string> corpus = ReadCorpus(folders);
  for (const std::string& input : corpus) Run(input);
  Mutator mutator(seed, corpus);
  for (std::uint64_t i = 0; i < runs; ++i) Run(mutator.Next());
  std::printf("%zu inputs of the corpus, %llu mutations, seed %llu: no complaint\n",
              corpus.size(),
              static_cast<unsigned long long>(runs),
              static_cast<unsigned long long>(seed));
  return 0;
}
