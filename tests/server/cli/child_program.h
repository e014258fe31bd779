#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace faultlab::server {

/// The result of a child process.
struct Finished {
  int exit_code = -1;  ///< -1: ended by a signal
  std::string out;
  std::string err;
};

/// A test with a folder of its own, in which `faultlab` runs through a shell.
class ChildProgram : public ::testing::Test {
 protected:
  ChildProgram();
  ~ChildProgram() override;

  /// Runs `faultlab ARGUMENTS` in the folder; `before` precedes it in the shell.
  Finished Run(const std::string& arguments, const std::string& before = "") const;
  void Write(const std::string& name, const std::string& text) const;
  std::string Read(const std::string& name) const;
  bool Exists(const std::string& name) const;
  std::string File(const std::string& name) const { return (folder_ / name).string(); }
  /// Names in the folder, sorted, separated by blanks.
  std::string Listing() const;

 private:
  std::filesystem::path folder_;
  std::filesystem::path streams_;
};

}  // namespace faultlab::server
