#pragma once
// The bench's commands, one function per part of the SCPI tree.
#include <memory>
#include <vector>

#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/command.hpp"
#include "daemon/remote/scpi/reply.hpp"

namespace shaker::instrument {

/// SOURce: requested motion of the base, and the predicted demands of that motion.
std::vector<scpi::Command> source_commands(BenchInstrument& bench);
/// OUTPut: drive on and off, protection.
std::vector<scpi::Command> output_commands(BenchInstrument& bench);
/// CONTrol: identification and the loop; FETCh:ACCeleration:HARMonics?.
std::vector<scpi::Command> control_commands(BenchInstrument& bench);
/// SOURce: FUNCtion and HARMonic, the shape of one period.
std::vector<scpi::Command> shape_commands(BenchInstrument& bench);
/// INITiate, TRIGger, AVERage, READ, MEASure: start of a measurement, and its parameters.
std::vector<scpi::Command> read_commands(BenchInstrument& bench);
/// CAMPaign: the points of a plan.
std::vector<scpi::Command> campaign_commands(BenchInstrument& bench);
/// FETCh: results of the newest measurement.
std::vector<scpi::Command> fetch_commands(BenchInstrument& bench);
/// RECord: recording of the following runs.
std::vector<scpi::Command> record_commands(BenchInstrument& bench);
/// SENSe: state of the sensors; STReam: address of the live streams.
std::vector<scpi::Command> sense_commands(BenchInstrument& bench);
/// Queries of one published quantity each.
std::vector<scpi::Command> published_commands(BenchInstrument& bench);
/// LIMit, SYSTem, DIAGnostic.
std::vector<scpi::Command> bench_commands(BenchInstrument& bench);

/// All of them, after the standard commands.
std::vector<scpi::Command> command_table(BenchInstrument& bench);

/// The newest result, for FETCh:DRIFt? and READ?; error -230 without a result.
std::shared_ptr<const reduction::Reduction> result_of(const service::BenchState& state);
void reply_drift(const service::BenchState& state, scpi::Reply& reply);
/// The same without a result: NaN, NaN, NaN, 0 periods, not measuring.
void reply_no_drift(scpi::Reply& reply);

}  // namespace shaker::instrument
