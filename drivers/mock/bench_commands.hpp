#pragma once
// Faults on command: one line of text each, as shaker-mock reads them.
#include <string>

#include "drivers/mock/bench.hpp"

namespace shaker {

/// All commands, a line each.
std::string bench_help();

/// Does what the line says and returns the answer as one JSON object: {"ok": true}, with "v_D_mps" or
/// "counts" where they were asked for. Throws InputError naming the word that was not understood, DeviceError
/// when a device refuses.
std::string bench_command(Bench& bench, const std::string& line);

}  // namespace shaker
