#include "server/cli/command_line.h"

int main(int argc, char** argv) {
  return faultlab::server::RunCommandLine(argc, argv);
}
