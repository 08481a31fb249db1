#pragma once
// A recording in a few words and numbers, for the list of recordings and the table of results.
#include <string>
#include <vector>

#include "daemon/catalogue/results_table.hpp"
#include "drivers/recorded/recording_file.hpp"

namespace shaker::catalogue {

struct RecordingSummary {
    static constexpr std::size_t most_rows = 500, most_remarks = 20;

    std::string title, kind;           // see RecordingHeader
    std::string started;               // UTC: "2026-11-26T19:43:32Z"
    std::string pictures;              // kept: "off", "region", "full"
    std::string outcome;               // "3 measurements", the limit that stopped the run, the reason of none
    std::size_t measurements = 0;      // finished ones
    std::vector<std::string> remarks;  // of the operator, the newest most_remarks
    std::vector<ResultRow> rows;       // the newest most_rows, also interrupted measurements
};

/// name: file name, for the rows. InputError when the file is no recording or damaged.
RecordingSummary summary_of(const recorded::RecordingReader& file, const std::string& name);
/// One line of JSON.
std::string summary_json(const RecordingSummary& summary);
/// The summary in JSON of a process that read a file of unknown origin; see row_from(). InputError when the
/// text is not JSON.
RecordingSummary summary_from(const std::string& json);

}  // namespace shaker::catalogue
