#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace faultlab::server {

/// Subcommands whose options live as long as this and whose `run` returns the status.
class Commands {
 protected:
  explicit Commands(std::function<int()>& chosen) : chosen_(chosen) {}

  template <typename Options>
  CLI::App& Add(CLI::App& app,
                const std::string& name,
                const std::string& about,
                Options& options,
                int (*run)(const Options&)) {
    CLI::App& command = *app.add_subcommand(name, about);
    command.callback(
        [&options, run, &chosen = chosen_] { chosen = [&options, run] { return run(options); }; });
    return command;
  }

 private:
  std::function<int()>& chosen_;
};

}  // namespace faultlab::server
