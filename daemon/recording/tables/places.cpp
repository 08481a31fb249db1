#include "daemon/recording/tables/places.hpp"

#include <spdlog/fmt/fmt.h>

#include <iterator>
#include <utility>

#include "daemon/recording/tables/identification_table.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/recording/tables/reduction_tables.hpp"
#include "daemon/recording/tables/run_tables.hpp"
#include "daemon/recording/tables/stream_tables.hpp"
#include "daemon/recording/tables/track_table.hpp"
#include "daemon/recording/tables/trip_table.hpp"
#include "drivers/errors.hpp"

namespace shaker::recording {

std::vector<recorded::GroupLayout> recording_places(const recorded::RecordingHeader& header, bool truth) {
    std::vector<recorded::GroupLayout> groups{process_places(), layout_of(note_columns)};
    const auto add = [&](std::vector<recorded::GroupLayout> more) {
        std::ranges::move(more, std::back_inserter(groups));
    };
    add(reduction_places());
    for (const View& view : header.views)
        for (const Target& target : view.targets)
            add({layout_of(track_columns, track_path(view.camera, target), view.frame_rate_hz)});
    for (const View& view : header.views) add({places_of(picture_columns, pictures_path(view.camera))});
    add({layout_of(clock_columns), layout_of(gap_columns)});
    add(run_places());
    add(measured_places());
    add(trip_places());
    add(identification_places());
    if (truth) add(truth_places(header.views));
    return groups;
}

void lay_out(recorded::RecordingHeader& header, bool truth) {
    header.schema = schema_version;
    header.groups = recording_places(header, truth);
}

void require_known_schema(const recorded::RecordingReader& file) {
    if (const int schema = file.header().schema; schema > schema_version)
        throw InputError{
            fmt::format("{}: layout version {} is newer than this program, which reads versions up to {}; "
                        "use the program "
                        "that recorded the file, or a newer one",
                        file.file().string(), schema, schema_version)};
}

}  // namespace shaker::recording
