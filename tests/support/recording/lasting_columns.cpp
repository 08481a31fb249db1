#include "tests/support/recording/lasting_columns.hpp"

#include <algorithm>

#include "drivers/recorded/h5/seals.hpp"
#include "drivers/recorded/opened_recording.hpp"

namespace shaker::test {

std::vector<std::string> lasting_columns(const recorded::RecordingReader& file) {
    std::vector<std::string> paths;
    for (const h5::SealedColumn& column : h5::read_seals(file.opened().entry.get())) {
        const bool live = column.path.starts_with("raw/") || column.path.starts_with("tracks/") ||
                          column.path.starts_with("events/") || column.path.starts_with("measurements/");
        const bool provisional = std::ranges::any_of(
            column.pieces, [](const h5::SealedPiece& p) { return p.checksum == h5::SealEntry::unchecked; });
        if (live && !provisional) paths.push_back(column.path);
    }
    return paths;
}

std::uint64_t same_rows(const h5::Bytes& is, const h5::Bytes& was) {
    const auto [end, ignored] = std::ranges::mismatch(is.values, was.values);
    return static_cast<std::uint64_t>(end - is.values.begin()) / is.row;
}

}  // namespace shaker::test
