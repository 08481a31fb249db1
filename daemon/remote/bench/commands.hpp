#pragma once
// The bench's rows of the table of commands, one function a part of the tree.
#include <memory>
#include <vector>

#include "daemon/remote/bench/instrument.hpp"
#include "daemon/remote/scpi/command.hpp"
#include "daemon/remote/scpi/reply.hpp"

namespace shaker {

/// SOURce: what the base is to do; OUTPut; CONTrol.
std::vector<scpi::Command> drive_commands(BenchInstrument& bench);
/// SOURce: FUNCtion, HARMonic and ARBitrary, how one period looks.
std::vector<scpi::Command> shape_commands(BenchInstrument& bench);
/// INITiate, TRIGger, READ, MEASure: what begins a measurement.
std::vector<scpi::Command> read_commands(BenchInstrument& bench);
/// FETCh, AVERage, RECord: what is measured.
std::vector<scpi::Command> measure_commands(BenchInstrument& bench);
/// SENSe: what the sensors are; STReam and MMEMory: where the live streams and the recordings are.
std::vector<scpi::Command> sense_commands(BenchInstrument& bench);
/// LIMit, SYSTem, DIAGnostic.
std::vector<scpi::Command> bench_commands(BenchInstrument& bench);

/// All of them, behind the standard ones.
std::vector<scpi::Command> command_table(BenchInstrument& bench);

/// The newest result, as FETCh:DRIFt? and READ? tell it; Error -230 where there is none.
std::shared_ptr<const Reduction> result_of(const BenchState& state);
void tell_drift(const BenchState& state, scpi::Reply& reply);

}  // namespace shaker
