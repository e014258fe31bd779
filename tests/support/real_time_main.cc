#include "tests/support/real_time.h"

int main(int argc, char** argv) {
  return faultlab::tests::RunInRealTime(argc, argv);
}
