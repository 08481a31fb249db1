#pragma once
// The bench's rows of the table of commands, one function a part of the tree.
#include <vector>

#include "daemon/remote/bench/instrument.hpp"
#include "daemon/remote/scpi/command.hpp"

namespace shaker {

/// SOURce: what the base is to do; OUTPut; CONTrol.
std::vector<scpi::Command> drive_commands(BenchInstrument& bench);
/// FETCh, AVERage, INITiate, RECord: what is measured.
std::vector<scpi::Command> measure_commands(BenchInstrument& bench);
/// SENSe: what the sensors are; STReam and MMEMory: where the live streams and the recordings are.
std::vector<scpi::Command> sense_commands(BenchInstrument& bench);
/// LIMit, SYSTem, DIAGnostic.
std::vector<scpi::Command> bench_commands(BenchInstrument& bench);

/// All of them, behind the standard ones.
std::vector<scpi::Command> command_table(BenchInstrument& bench);

}  // namespace shaker
