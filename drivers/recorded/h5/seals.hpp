#pragma once
// Seals: checksums that show which part of a recording is intact, however it ended.
//
// Each flush writes a seal: for every column that has grown, its number of rows and the CRC-32C of the bytes
// added since the previous seal; the last entry is for the seal itself. Data after the last whole seal are
// not verified.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/recorded/h5/growing.hpp"

namespace shaker::h5 {

struct SealEntry {
    static constexpr std::int64_t whole = -1;  // column number of the entry that ends a seal
    std::int64_t seal = 0;                     // counts from 1
    std::int64_t column = 0;                   // index into the list of columns
    std::int64_t rows = 0;  // of the column; in the last entry: number of entries of this seal before it
    std::int64_t checksum =
        0;  // of the added bytes (unchecked: provisional column); in the last entry: of those entries
    static constexpr std::int64_t unchecked = -1;
};

class SealWriter {
public:
    /// Creates /entry/seals with the names of the columns (paths under /entry) in the order of their numbers.
    SealWriter(hid_t entry, const std::vector<std::string>& columns);
    /// Continues a file whose seals are to be rewritten.
    SealWriter(hid_t entry, std::size_t columns);
    /// Adds one column to the seal in progress if it has grown.
    void add(std::size_t column, hsize_t rows, std::int64_t checksum);
    /// Ends the seal and writes it, unless nothing has grown.
    void flush();

private:
    h5::Growing seal_, column_, rows_, checksum_;
    std::vector<SealEntry> entries_;
    std::vector<hsize_t> sealed_;  // number of rows, for each column
    std::int64_t number_ = 0;
};

/// A range of rows of a column with its checksum.
struct SealedPiece {
    hsize_t from = 0, to = 0;  // rows
    std::int64_t checksum = 0;
    std::int64_t seal = 0;
};
struct SealedColumn {
    std::string path;
    std::vector<SealedPiece> pieces;  // consecutive, from row 0
    /// Number of intact rows: those of the pieces before the first wrong one.
    [[nodiscard]] hsize_t good_rows(std::span<const std::byte> bytes, std::size_t row_bytes) const;
};
/// Contents of the seals of a file up to the first that is not whole. InputError when there is no list.
std::vector<SealedColumn> read_seals(hid_t entry);

}  // namespace shaker::h5
