#pragma once
// Commands that cause faults, one line of text each, read by shaker-mock.
#include <string>

#include "tests/mock/mock_bench.hpp"

namespace shaker::mock {

/// Help: all commands, one per line.
std::string bench_help();

/// Executes a line and returns the answer as one JSON object: {"ok": true}, with "v_D_mps" or "counts" if
/// requested. Throws InputError that names the word not understood, DeviceError when a device refuses.
std::string bench_command(MockBench& bench, const std::string& line);

}  // namespace shaker::mock
