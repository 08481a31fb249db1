// Reads rows of a recording, also of one that is being written.
#include <algorithm>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/written_file.hpp"
#include "drivers/recorded/opened_recording.hpp"
#include "drivers/recorded/recording_streams.hpp"

namespace shaker::recorded {

namespace {

template <h5::Element T>
std::vector<T> rows_of(Numbered& column, std::size_t first, std::size_t count, std::size_t values = 1) {
    std::vector<T> rows(values * count);
    column.data.read<T>(first, rows);
    return rows;
}

/// A range that is open at its end in words.
std::string range_of(const RawColumn& column) {
    std::string text = "must be at least " + std::to_string(column.least);
    if (column.most != RawColumn{}.most) text += " and at most " + std::to_string(column.most);
    return text;
}

}  // namespace

void require_length(std::size_t values, std::size_t expected, const std::string& path) {
    if (values != expected)
        throw InputError{"recording: " + path + " has " + std::to_string(values) + " entries beside " +
                         std::to_string(expected)};
}

std::vector<std::byte> read_values(hid_t entry, const RawColumn& column, const std::string& path) {
    return with_zero(column.type, [&]<class T>(T) {
        const std::vector<T> values = h5::read<T>(entry, path);
        if constexpr (std::same_as<T, std::int64_t> || std::same_as<T, std::uint8_t>) {
            for (const T n : values)
                if (n < column.least || n > column.most)
                    throw InputError{"recording: " + path + " " + std::to_string(n) + ": " +
                                     range_of(column)};
        }
        const auto bytes = std::as_bytes(std::span{values});
        return std::vector<std::byte>{bytes.begin(), bytes.end()};
    });
}

std::vector<double> RecordingWriter::numbers(const std::string& path, std::size_t first, std::size_t count) {
    std::vector<double> rows = rows_of<double>(streams_->column(path), first, count);
    h5::written_file(streams_->file.get())->require_whole(streams_->name);
    return rows;
}

std::vector<AccelBlock> RecordingWriter::blocks(std::size_t first, std::size_t count,
                                                std::size_t first_sample) {
    std::vector<RawBlock> heads(count);
    for (std::size_t i = 0; i < raw::blocks.size(); ++i) {
        std::vector<std::byte> values(count * raw::blocks[i].bytes());
        streams_->blocks[i]->data.read_bytes(first, values);
        for (std::size_t k = 0; k < count; ++k)
            raw::blocks[i].set(heads[k], values.data() + k * raw::blocks[i].bytes());
    }
    std::size_t samples = 0;
    for (const RawBlock& head : heads) samples += head.size;
    const auto counts = rows_of<std::int32_t>(*streams_->counts, first_sample, samples, raw::axes);
    h5::written_file(streams_->file.get())->require_whole(streams_->name);
    std::vector<AccelBlock> blocks;
    std::size_t next = 0;
    for (const RawBlock& head : heads) {
        AccelBlock& block = blocks.emplace_back();
        block = {.first = head.first, .arrived = head.arrived, .quality = head.quality, .size = head.size};
        for (std::size_t i = 0; i < head.size; ++i)
            for (std::size_t axis = 0; axis < raw::axes; ++axis) block.counts[i][axis] = counts[next++];
    }
    return blocks;
}

}  // namespace shaker::recorded
