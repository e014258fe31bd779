#pragma once

#include <functional>
#include <memory>

namespace CLI {
class App;
}

namespace faultlab::server {

/// Adds a group of subcommands. Parsing fills options that live in the returned object, and sets
/// `chosen` to the function that runs the command and returns the exit status.
using CommandGroup = std::shared_ptr<const void>;

CommandGroup AddLabCommands(CLI::App& app, std::function<int()>& chosen);
CommandGroup AddRecordCommands(CLI::App& app, std::function<int()>& chosen);
CommandGroup AddModelCommands(CLI::App& app, std::function<int()>& chosen);
CommandGroup AddAdminCommands(CLI::App& app, std::function<int()>& chosen);

}  // namespace faultlab::server
