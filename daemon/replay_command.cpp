#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdio>
#include <iterator>

#include "daemon/acquisition.hpp"
#include "daemon/commands.hpp"
#include "daemon/recorder.hpp"
#include "daemon/results.hpp"

namespace shaker {

bool replay(const ReplayOptions& options) {
    const SessionReader file{options.file};
    const SessionHeader& header = file.header();
    spdlog::info("replaying \"{}\" from {}", header.title,
                 header.keep_frames ? "frames and counts" : "tracks and counts");
    Rig rig = replay_rig(file);
    Acquisition acquisition{rig, nullptr};
    read_all(acquisition);
    Take& take = acquisition.take();
    take.dac_rate_hz = header.dac.rate_hz;
    take.played = file.play_times();
    take.changes = file.changes();
    std::vector<std::string> notes;
    if (header.keep_frames)
        settle_times(take, notes);
    else
        read_tracks(file, take);

    Reduction reduction = reduce(measurement_of(
        take, header.frequency_hz, file.scalar("process/reduced_from"), file.scalar("process/reduced_to")));
    std::ranges::move(notes, std::back_inserter(reduction.notes));
    std::vector<RecordedTable> tables = tables_of(reduction);
    for (RecordedTable& t : tables_of(take)) tables.push_back(std::move(t));
    const std::vector<RecordedNumber> numbers = numbers_of(reduction);
    const std::vector<std::string> found = differences(file, numbers, tables);

    std::fputs((options.json ? results_json(reduction) + "\n" : results_text(reduction)).c_str(), stdout);
    if (found.empty()) {
        std::size_t values = numbers.size();
        for (const RecordedTable& t : tables)
            for (const Column& c : t.columns) values += c.values.size();
        spdlog::info("replay identical: {} numbers equal to the bit", values);
        if (!options.json) fmt::print("replay: identical ({} numbers, to the bit)\n", values);
        return true;
    }
    for (std::size_t i = 0; i < std::min<std::size_t>(found.size(), 20); ++i)
        spdlog::warn("differs: {}", found[i]);
    if (!options.json) fmt::print("replay: NOT identical, {} differences\n", found.size());
    return false;
}

}  // namespace shaker
