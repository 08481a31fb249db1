#include "daemon/session_places.hpp"

#include <algorithm>
#include <utility>

#include "daemon/identification_record.hpp"
#include "daemon/recorder.hpp"
#include "daemon/run_log.hpp"
#include "daemon/trip_record.hpp"

namespace shaker {

namespace {

constexpr std::size_t sentence = 512;  // bytes of the longest

// Live times are provisional until all stamps are known.
GroupLayout track_layout(const RecordedTable& table, double rate_hz) {
    GroupLayout layout = layout_of(table, rate_hz);
    std::ranges::find(layout.places, "t", &Place::name)->provisional = true;
    return layout;
}

}  // namespace

GroupLayout layout_of(const RecordedTable& table, double rows_per_s) {
    GroupLayout layout{table.path, table.nx_class, table.attributes, {}, rows_per_s};
    for (const Column& c : table.columns)
        layout.places.push_back({c.name, c.units, Place::Kind::numbers, 0, false});
    return layout;
}

GroupLayout layout_of(const std::string& path, const std::vector<RecordedNumber>& numbers) {
    GroupLayout layout{path, "NXcollection", {}, {}, 0};
    for (const RecordedNumber& n : numbers)
        layout.places.push_back({n.path.substr(path.size() + 1), n.units, Place::Kind::number, 0, false});
    return layout;
}

std::vector<GroupLayout> session_places(const SessionHeader& header, bool truth) {
    std::vector<GroupLayout> groups;
    groups.push_back({"process",
                      "NXprocess",
                      {},
                      {{"reduced_from", "s", Place::Kind::number, 0, false},
                       {"reduced_to", "s", Place::Kind::number, 0, false},
                       {"pieces_lost", "1", Place::Kind::number, 0, false},
                       {"not_reduced", "", Place::Kind::text, sentence, false},
                       {"recovered", "", Place::Kind::text, sentence, false}},
                      0});
    groups.push_back(
        {"results/notes", "NXcollection", {}, {{"text", "", Place::Kind::texts, sentence, false}}, 0});
    groups.push_back(layout_of("results", numbers_of(Reduction{})));
    for (const RecordedTable& t : tables_of(Reduction{})) groups.push_back(layout_of(t));
    for (const View& view : header.views)
        for (const Target& target : view.targets)
            groups.push_back(track_layout(track_table({view.camera, target, {}}), view.frame_rate_hz));
    for (const View& view : header.views)
        groups.push_back(layout_of("pictures/" + view.camera, picture_numbers(view.camera, {})));
    groups.push_back(layout_of(clock_table({})));
    groups.push_back(layout_of(gap_table({})));
    for (GroupLayout& g : run_log_places()) groups.push_back(std::move(g));
    for (GroupLayout& g : trip_places()) groups.push_back(std::move(g));
    for (GroupLayout& g : identification_places()) groups.push_back(std::move(g));
    if (truth) {
        groups.push_back({"truth", "NXcollection", {}, {{"v_D", "m/s", Place::Kind::number, 0, false}}, 0});
        for (const View& view : header.views)
            groups.push_back(layout_of(truth_table(view.camera, {}), view.frame_rate_hz));
    }
    return groups;
}

}  // namespace shaker
