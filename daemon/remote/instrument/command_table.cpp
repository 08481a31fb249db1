#include "daemon/remote/instrument/commands.hpp"
#include "daemon/remote/scpi/standard_commands.hpp"

namespace shaker::instrument {

std::vector<scpi::Command> command_table(BenchInstrument& bench) {
    std::vector<scpi::Command> rows;
    for (auto* part : {&source_commands, &shape_commands, &output_commands, &control_commands, &read_commands,
                       &fetch_commands, &campaign_commands, &record_commands, &sense_commands,
                       &published_commands, &bench_commands})
        for (scpi::Command& row : part(bench)) rows.push_back(std::move(row));
    return scpi::with_standard_commands(std::move(rows));
}

}  // namespace shaker::instrument
