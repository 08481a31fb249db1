// Reads rows of a recording that is being written.
#include <numeric>

#include "drivers/recorded/h5/written_file.hpp"
#include "drivers/recorded/recording_streams.hpp"

namespace shaker::recorded {

namespace {

template <h5::Element T>
std::vector<T> rows_of(Numbered& column, std::size_t first, std::size_t count, std::size_t values = 1) {
    std::vector<T> rows(values * count);
    column.data.read<T>(first, rows);
    return rows;
}

}  // namespace

std::vector<double> RecordingWriter::numbers(const std::string& path, std::size_t first, std::size_t count) {
    std::vector<double> rows = rows_of<double>(streams_->column(path), first, count);
    h5::written_file(streams_->file.get())->require_whole(streams_->name);
    return rows;
}

std::vector<AccelBlock> RecordingWriter::blocks(std::size_t first, std::size_t count,
                                                std::size_t first_sample) {
    const auto tick = rows_of<std::int64_t>(*streams_->block_first, first, count),
               arrived = rows_of<std::int64_t>(*streams_->block_arrived, first, count);
    const auto quality = rows_of<std::uint8_t>(*streams_->block_quality, first, count),
               size = rows_of<std::uint8_t>(*streams_->block_size, first, count);
    const auto samples = std::accumulate(size.begin(), size.end(), std::size_t{0});
    const auto counts = rows_of<std::int32_t>(*streams_->counts, first_sample, samples, raw::axes);
    h5::written_file(streams_->file.get())->require_whole(streams_->name);
    std::vector<AccelBlock> blocks;
    std::size_t next = 0;
    for (std::size_t k = 0; k < count; ++k) {
        AccelBlock& block = blocks.emplace_back();
        block.first = {tick[k]};
        block.arrived = HostTime{std::chrono::nanoseconds{arrived[k]}};
        block.quality = static_cast<Quality>(quality[k]);
        block.size = size[k];
        for (std::size_t i = 0; i < size[k]; ++i)
            for (std::size_t axis = 0; axis < raw::axes; ++axis) block.counts[i][axis] = counts[next++];
    }
    return blocks;
}

}  // namespace shaker::recorded
