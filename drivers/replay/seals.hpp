#pragma once
// Checksums that tell how much of a recording is what was written, however it ended.
//
// With each flush a seal is written: for every column that has grown since the seal before, how many rows it
// has now and the CRC-32C of the bytes that were added; at last an entry for the seal itself. What lies
// behind the last whole seal cannot be vouched for.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/replay/growing.hpp"

namespace shaker {

struct SealEntry {
    static constexpr std::int64_t whole = -1;  // the column of the entry that ends a seal
    std::int64_t seal = 0;                     // counts from 1
    std::int64_t column = 0;                   // index into the list of columns
    std::int64_t rows = 0;  // of the column; in the last entry: entries of this seal before it
    std::int64_t checksum =
        0;  // of the bytes added (unchecked: of a provisional column); at last: of those entries
    static constexpr std::int64_t unchecked = -1;
};

class SealWriter {
public:
    /// Makes /entry/seals with the names of the columns (paths under /entry) in the order of their numbers.
    SealWriter(hid_t entry, const std::vector<std::string>& columns);
    /// Goes on with a file whose seals are to be made anew.
    SealWriter(hid_t entry, std::size_t columns);
    /// One column of the seal that is being made, if it has grown.
    void add(std::size_t column, hsize_t rows, std::int64_t checksum);
    /// Ends the seal and writes it; none when nothing has grown.
    void flush();

private:
    h5::Growing seal_, column_, rows_, checksum_;
    std::vector<SealEntry> entries_;
    std::vector<hsize_t> sealed_;  // rows, one a column
    std::int64_t number_ = 0;
};

/// A piece of a column and what it should be.
struct SealedPiece {
    hsize_t from = 0, to = 0;  // rows
    std::int64_t checksum = 0;
    std::int64_t seal = 0;
};
struct SealedColumn {
    std::string path;
    std::vector<SealedPiece> pieces;  // behind each other, from row 0
    /// Rows that are what was written: those of the pieces before the first wrong one.
    [[nodiscard]] hsize_t good_rows(std::span<const std::byte> bytes, std::size_t row_bytes) const;
};
/// What the whole seals of a file say, up to the first one that is not whole. InputError when there is no
/// list.
std::vector<SealedColumn> read_seals(hid_t entry);

}  // namespace shaker
