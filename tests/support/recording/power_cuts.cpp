#include "tests/support/recording/power_cuts.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>

#include "drivers/recorded/h5/crc32c.hpp"
#include "drivers/recorded/opened_recording.hpp"
#include "drivers/recorded/pictures/picture_check.hpp"
#include "drivers/recorded/pictures/picture_reader.hpp"
#include "tests/support/environment.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/recording/lasting_columns.hpp"

namespace shaker::test {

namespace {

constexpr const char* recording_name = "run.nxs";

struct Picture {
    std::int64_t tick;
    std::uint32_t checksum;
    bool operator==(const Picture&) const = default;
};

Picture picture_of(const Frame& frame) { return {frame.tick.n, h5::crc32c(std::span{frame.pixels})}; }

bool is_picture_number(const std::string& path) {
    return path.starts_with("raw/") && path.ends_with("/picture");
}

void expect_synced(const std::string& path, std::uint64_t there,
                   const std::map<std::string, std::uint64_t>& synced, PowerCut& result) {
    const auto at = synced.find(path);
    const std::uint64_t before = at == synced.end() ? 0 : at->second;
    if (there >= before) {
        result.unsynced_saved += there - before;
        return;
    }
    result.synced_lost += before - there;
    result.words = fmt::format("{}: {} of {} synced rows", path, there, before);
}

void tell_bad(const std::string& path, std::uint64_t row, PowerCut& result) {
    ++result.bad;
    result.words = fmt::format("{}: row {} is not that of the run", path, row);
}

std::map<std::string, std::vector<Picture>> all_pictures(const recorded::RecordingReader& file) {
    std::map<std::string, std::vector<Picture>> all;
    for (const View& view : file.header().views) {
        pictures::PictureReader pictures{recorded::pictures_folder(file.file()), view.camera};
        for (std::uint64_t i = 0; i < pictures.count(); ++i) {
            all[view.camera].push_back(picture_of(*pictures.read(i)));
        }
    }
    return all;
}

// Random, but successive seeds are spread over the whole run: multiples of the golden ratio.
std::size_t cut_of(std::uint64_t seed, std::size_t calls) {
    constexpr double golden = 0.6180339887498949;
    std::mt19937_64 random{seed};
    const double place =
        golden * static_cast<double>(seed) + std::uniform_real_distribution{0.0, 0.1}(random);
    return static_cast<std::size_t>((place - std::floor(place)) * static_cast<double>(calls + 1));
}

}  // namespace

struct PowerCuts::Reference {
    std::vector<std::string> columns;
    std::map<std::string, h5::Bytes> bytes;
    std::map<std::string, std::vector<Picture>> pictures;  // a camera's
};

PowerCuts::~PowerCuts() = default;

PowerCuts::PowerCuts(std::filesystem::path folder) : folder_{std::move(folder)} {
    std::filesystem::create_directories(folder_ / "run");
    folder_ = std::filesystem::canonical(folder_);
    const std::filesystem::path run = folder_ / "run", log = folder_ / "log";
    {
        const Environment logged{{{"LD_PRELOAD", test::build_dir() + "/preload_disk_log.so"},
                                  {"SHAKER_DISK_FOLDER", run.string()},
                                  {"SHAKER_DISK_LOG", log.string()}}};
        const Outcome outcome =
            shakerd(fmt::format("run --rig sim: --threads --real-time --no-identify --frames full --phi 2.17 "
                                "--periods 40 -o {} "
                                "--scene '{}'",
                                recording_name, test::source_dir() + "/tests/support/slow_cameras.toml"),
                    run);
        if (outcome.status != 0) throw std::runtime_error{"the run to be cut: " + outcome.err};
    }
    images_ = std::make_unique<DiskImages>(log, run);
    reference_ = std::make_unique<Reference>();
    const recorded::RecordingReader file{run / recording_name};
    reference_->columns = lasting_columns(file);
    for (const std::string& path : reference_->columns)
        reference_->bytes[path] = h5::read_bytes(file.opened().entry.get(), path);
    reference_->pictures = all_pictures(file);
    look_at_syncs();
}

// A sync writes the content that the files had at its start.
void PowerCuts::look_at_syncs() {
    const std::vector<std::size_t> cuts = images_->syncs(std::string{recording_name} + ".part");
    for (const std::size_t cut : cuts) {
        const std::filesystem::path folder = folder_ / "synced";
        std::filesystem::create_directories(folder);
        images_->build(folder, cut, Surviving::all, 0);
        const auto state = cut == cuts.back() ? recorded::RecordingReader::Open::finished
                                              : recorded::RecordingReader::Open::growing;
        const recorded::RecordingReader file{folder / (std::string{recording_name} + ".part"), state};
        Synced synced{cut, {}};
        for (const std::string& path : reference_->columns)
            synced.rows[path] = h5::description_of(file.opened().entry.get(), path).shape.at(0);
        for (const View& view : file.header().views) {
            const std::vector<std::uint64_t> numbers = file.pictures_of(view.camera);
            synced.rows["pictures/" + view.camera] = numbers.empty() ? 0 : std::ranges::max(numbers);
        }
        synced_.push_back(std::move(synced));
        std::filesystem::remove_all(folder);
    }
}

void PowerCuts::compare(const std::filesystem::path& recording, const Rows& synced, PowerCut& result) const {
    const recorded::RecordingReader file{recording};
    for (const std::string& sentence : file.damage()) {
        ++result.bad;
        result.words = sentence;
    }
    for (const std::string& path : reference_->columns) {
        const h5::Bytes is = h5::read_bytes(file.opened().entry.get(), path);
        expect_synced(path, is.values.size() / is.row, synced, result);
        if (is_picture_number(path)) continue;
        const std::uint64_t same = same_rows(is, reference_->bytes.at(path));
        if (same * is.row != is.values.size()) tell_bad(path, same, result);
    }
    for (const View& view : file.header().views) {
        const std::string path = "pictures/" + view.camera;
        const std::vector<std::uint64_t> numbers = file.pictures_of(view.camera);
        const std::vector<Frame> frames = file.frames(view.camera);
        const std::vector<Picture>& was = reference_->pictures.at(view.camera);
        std::optional<pictures::PictureReader> pictures;
        const auto at = synced.find(path);
        const std::uint64_t last_synced = at == synced.end() ? 0 : at->second;
        std::uint64_t kept = 0;
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            if (numbers[i] == 0) continue;
            if (!pictures) pictures.emplace(recorded::pictures_folder(recording), view.camera);
            const Picture is = picture_of(*pictures->read(numbers[i] - 1));
            if (is.tick != frames[i].tick.n || numbers[i] > was.size() || is != was[numbers[i] - 1])
                tell_bad(path, numbers[i], result);
            ++(numbers[i] <= last_synced ? kept : result.unsynced_saved);
        }
        expect_synced(path, kept, synced, result);
    }
}

PowerCut PowerCuts::cut(Surviving surviving, std::uint64_t seed, const std::filesystem::path& folder) const {
    const std::size_t at = cut_of(seed, images_->size());
    PowerCut result;
    Rows synced;
    for (const Synced& s : synced_)
        if (s.cut <= at) synced = s.rows;
    result.anything_synced = !synced.empty();
    images_->build(folder, at, surviving, seed);
    const Outcome recover = shakerd(fmt::format("recover {}", recording_name), folder);
    result.recovered = recover.status == 0;
    if (!result.recovered) {
        result.words = fmt::format("status {}: {}{}", recover.status, recover.out, recover.err);
        return result;
    }
    static std::mutex hdf5;  // it has one user at a time
    try {
        const std::scoped_lock lock{hdf5};
        compare(folder / recording_name, synced, result);
    } catch (const std::exception& e) {
        result.recovered = false;
        result.words = e.what();
        return result;
    }
    const Outcome again = shakerd(fmt::format("recover {}", recording_name), folder);
    if (again.status != 0) {
        result.recovered = false;
        result.words = again.out + again.err;
    }
    return result;
}

}  // namespace shaker::test
