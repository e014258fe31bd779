#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace faultlab::server {

/// Adds a subcommand whose options live as long as the program and whose `run` returns the status.
template <typename Options>
CLI::App& AddCommand(CLI::App& app,
                     const std::string& name,
                     const std::string& about,
                     Options& options,
                     int (*run)(const Options&),
                     std::function<int()>& chosen) {
  CLI::App& command = *app.add_subcommand(name, about);
  command.callback([&options, run, &chosen] { chosen = [&options, run] { return run(options); }; });
  return command;
}

}  // namespace faultlab::server
