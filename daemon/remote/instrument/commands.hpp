#pragma once
// The bench's commands, one function per part of the SCPI tree.
#include <memory>
#include <vector>

#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/command.hpp"
#include "daemon/remote/scpi/data/reply.hpp"

namespace shaker::instrument {

/// SOURce: requested motion of the base; OUTPut; CONTrol.
std::vector<scpi::Command> drive_commands(BenchInstrument& bench);
/// SOURce: FUNCtion, HARMonic and ARBitrary, the shape of one period.
std::vector<scpi::Command> shape_commands(BenchInstrument& bench);
/// INITiate, TRIGger, READ, MEASure: start of a measurement.
std::vector<scpi::Command> read_commands(BenchInstrument& bench);
/// FETCh, AVERage, RECord: results.
std::vector<scpi::Command> measure_commands(BenchInstrument& bench);
/// SENSe: properties of the sensors; STReam and MMEMory: addresses of live streams and recordings.
std::vector<scpi::Command> sense_commands(BenchInstrument& bench);
/// LIMit, SYSTem, DIAGnostic.
std::vector<scpi::Command> bench_commands(BenchInstrument& bench);

/// All of them, after the standard commands.
std::vector<scpi::Command> command_table(BenchInstrument& bench);

/// The newest result, for FETCh:DRIFt? and READ?; Error -230 when there is none.
std::shared_ptr<const reduction::Reduction> result_of(const service::BenchState& state);
void tell_drift(const service::BenchState& state, scpi::Reply& reply);
/// The same without a result: NaN, NaN, NaN, 0 periods, not measuring.
void tell_no_drift(scpi::Reply& reply);

}  // namespace shaker::instrument
