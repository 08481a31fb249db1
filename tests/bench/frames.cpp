// Two cameras of 1000 pictures/s onto the disk in real time: losses, delay, cost.
//   --seconds N (20)   --folder FOLDER (in the build folder): needs 0.66 GB per second; its files are removed
//   afterwards
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "drivers/frame_pool.hpp"
#include "drivers/handover.hpp"
#include "drivers/recorded/h5/h5.hpp"
#include "drivers/recorded/pictures/picture_reader.hpp"
#include "drivers/recorded/pictures/picture_store.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/cost.hpp"
#include "tests/support/paths.hpp"

namespace shaker {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr pictures::PictureShape shape{1280, 256, 1};
constexpr std::size_t cameras = 2;
constexpr std::size_t ring_frames = 2000;  // 2 s
constexpr std::chrono::microseconds interval{1000};

double seconds_of(Clock::duration d) { return std::chrono::duration<double>(d).count(); }

/// Pictures of sensor noise; each contains its number at the beginning, middle and end.
class Scene {
public:
    Scene() {
        std::mt19937 random{1};
        for (auto& base : bases_) {
            base.resize(shape.bytes());
            for (std::byte& b : base) b = static_cast<std::byte>(80 + random() % 64);
        }
    }
    void draw(std::uint64_t number, std::span<std::byte> pixels) const {
        const auto& base = bases_[number % bases_.size()];
        std::memcpy(pixels.data(), base.data(), pixels.size());
        for (const std::size_t at : {std::size_t{0}, pixels.size() / 2, pixels.size() - sizeof number})
            std::memcpy(&pixels[at], &number, sizeof number);
    }

private:
    std::array<std::vector<std::byte>, 16> bases_;
};

/// Destination of pictures, with a way to read them back.
class Sink {
public:
    virtual ~Sink() = default;
    /// more: another picture of this camera is waiting.
    virtual void add(std::size_t camera, const Frame& frame, bool more) = 0;
    virtual void finish() = 0;
    virtual std::uint64_t count(std::size_t camera) = 0;
    /// Stored picture number `k`: its tick and pixels.
    virtual std::int64_t read(std::size_t camera, std::uint64_t k, std::vector<std::byte>& pixels) = 0;
};

const std::string& name_of(std::size_t camera) {
    static const std::array<std::string, cameras> names{"top", "side"};
    return names[camera];
}

class Segments final : public Sink {
public:
    explicit Segments(const fs::path& folder) : folder_{folder / "run.frames"} {
        for (std::size_t c = 0; c < cameras; ++c) {
            stores_.push_back(std::make_unique<pictures::PictureStore>(folder_, name_of(c)));
            stores_.back()->prepare(shape);
        }
    }
    void add(std::size_t camera, const Frame& frame, bool more) override {
        stores_[camera]->add(frame, more);
    }
    void finish() override {
        for (std::size_t c = 0; c < cameras; ++c) {
            stores_[c]->finish();
            readers_.emplace_back(folder_, name_of(c));
        }
    }
    std::uint64_t count(std::size_t camera) override { return readers_[camera].count(); }
    std::int64_t read(std::size_t camera, std::uint64_t k, std::vector<std::byte>& pixels) override {
        const FramePtr frame = readers_[camera].read(k);
        pixels = frame->pixels;
        return frame->tick.n;
    }

private:
    fs::path folder_;
    std::vector<std::unique_ptr<pictures::PictureStore>> stores_;
    std::vector<pictures::PictureReader> readers_;
};

/// Reference with plain HDF5: one chunk per picture, readable while it grows, flushed every half second.
class Chunks final : public Sink {
public:
    explicit Chunks(const fs::path& folder) {
        const h5::Handle access{H5Pcreate(H5P_FILE_ACCESS), "access"};
        h5::check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_LATEST, H5F_LIBVER_LATEST), "version");
        file_ = {H5Fcreate((folder / "run.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), "file"};
        const std::array<hsize_t, 3> none{0, shape.height, shape.width}, chunk{1, shape.height, shape.width},
            most{H5S_UNLIMITED, shape.height, shape.width};
        const h5::Handle create{H5Pcreate(H5P_DATASET_CREATE), "create"};
        h5::check(H5Pset_chunk(create.get(), 3, chunk.data()), "chunk");
        const h5::Handle space{H5Screate_simple(3, none.data(), most.data()), "space"};
        for (std::size_t c = 0; c < cameras; ++c)
            sets_[c] = {H5Dcreate2(file_.get(), name_of(c).c_str(), H5T_STD_U8LE, space.get(), H5P_DEFAULT,
                                   create.get(), H5P_DEFAULT),
                        name_of(c)};
        h5::check(H5Fstart_swmr_write(file_.get()), "readers beside the writer");
    }
    void add(std::size_t camera, const Frame& frame, bool) override {
        const std::array<hsize_t, 3> extent{ticks_[camera].size() + 1, shape.height, shape.width},
            at{ticks_[camera].size(), 0, 0};
        h5::check(H5Dset_extent(sets_[camera].get(), extent.data()), "growing");
        h5::check(H5Dwrite_chunk(sets_[camera].get(), H5P_DEFAULT, 0, at.data(), frame.pixels.size(),
                                 frame.pixels.data()),
                  "chunk");
        ticks_[camera].push_back(frame.tick.n);
        if (Clock::now() - flushed_ < std::chrono::milliseconds{500}) return;
        h5::check(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL), "flush");
        flushed_ = Clock::now();
    }
    void finish() override { h5::check(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL), "flush"); }
    std::uint64_t count(std::size_t camera) override {
        const h5::Handle space{H5Dget_space(sets_[camera].get()), "space"};
        return static_cast<std::uint64_t>(H5Sget_simple_extent_npoints(space.get())) / shape.bytes();
    }
    std::int64_t read(std::size_t camera, std::uint64_t k, std::vector<std::byte>& pixels) override {
        pixels.resize(shape.bytes());
        h5::read_row<std::uint8_t>(file_.get(), name_of(camera), k,
                                   {reinterpret_cast<std::uint8_t*>(pixels.data()), pixels.size()});
        return ticks_[camera][k];
    }

private:
    h5::Handle file_;
    std::array<h5::Handle, cameras> sets_;
    std::array<std::vector<std::int64_t>, cameras> ticks_;
    Clock::time_point flushed_ = Clock::now();
};

/// One camera: a picture every millisecond, dropped if no buffer is free.
struct Source {
    std::unique_ptr<FramePool> pool =
        std::make_unique<FramePool>(ring_frames + 16, shape.width, shape.height, shape.bytes_per_pixel);
    Ring<FramePtr> ring{ring_frames};
    std::uint64_t dropped = 0;
    double cpu_s = 0;

    void run(const Scene& scene, std::uint64_t pictures, Clock::time_point begin) {
        for (std::uint64_t n = 0; n < pictures; ++n) {
            std::this_thread::sleep_until(begin + n * interval);
            const auto frame = pool->acquire();
            if (frame) {
                frame->tick = {static_cast<std::int64_t>(n)};
                frame->arrived = HostTime{Clock::now().time_since_epoch()};
                scene.draw(n, frame->pixels);
            }
            if (!frame || !ring.push(frame)) ++dropped;
        }
        cpu_s = bench::cpu_ns() / 1e9;
    }
};

struct Written {
    double backlog_s = 0, longest_s = 0, cpu_s = 0;
};

Written write_all(Sink& sink, std::array<Source, cameras>& sources, const std::atomic<bool>& over) {
    Written w;
    std::array<std::optional<FramePtr>, cameras> next;
    while (true) {
        const bool last_round = over;
        bool idle = true;
        for (std::size_t c = 0; c < cameras; ++c) {
            const std::optional<FramePtr> frame = next[c] ? std::move(next[c]) : sources[c].ring.pop();
            next[c].reset();
            if (!frame) continue;
            next[c] = sources[c].ring.pop();
            idle = false;
            const auto now = Clock::now();
            w.backlog_s = std::max(w.backlog_s,
                                   seconds_of(now.time_since_epoch() - (*frame)->arrived.time_since_epoch()));
            sink.add(c, **frame, next[c].has_value());
            w.longest_s = std::max(w.longest_s, seconds_of(Clock::now() - now));
        }
        if (idle && last_round) break;
        if (idle) std::this_thread::sleep_for(interval);
    }
    w.cpu_s = bench::cpu_ns() / 1e9;
    return w;
}

double process_cpu_s() {
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    const auto s = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return s(used.ru_utime) + s(used.ru_stime);
}

/// Number of pictures of a sample that differ from the produced ones.
std::string errors_of(Sink& sink, const Scene& scene) {
    constexpr std::uint64_t step = 23;
    std::uint64_t wrong = 0, tried = 0;
    std::vector<std::byte> read, expected(shape.bytes());
    for (std::size_t c = 0; c < cameras; ++c)
        for (std::uint64_t k = 0; k < sink.count(c); k += step, ++tried) {
            const std::int64_t tick = sink.read(c, k, read);
            scene.draw(static_cast<std::uint64_t>(tick), expected);
            wrong += read == expected ? 0 : 1;
        }
    return std::to_string(wrong) + " of " + std::to_string(tried);
}

template <class S>
void add_row(bench::Table& table, const std::string& method, const fs::path& folder, int seconds,
             const Scene& scene) {
    std::fprintf(stderr, "%s: %d s\n", method.c_str(), seconds);
    fs::remove_all(folder);
    fs::create_directories(folder);
    const auto pictures = static_cast<std::uint64_t>(seconds) * 1000;
    std::array<Source, cameras> sources;
    const std::unique_ptr<Sink> sink = std::make_unique<S>(folder);
    std::atomic<bool> over{false};
    Written written;
    const double before_s = process_cpu_s();
    const auto begin = Clock::now() + std::chrono::milliseconds{50};
    std::exception_ptr failure;
    std::thread writer{[&] {
        try {
            written = write_all(*sink, sources, over);
        } catch (...) {
            failure = std::current_exception();
        }
    }};
    {
        std::vector<std::jthread> cameras_running;
        cameras_running.reserve(cameras);
        for (Source& s : sources) cameras_running.emplace_back([&] { s.run(scene, pictures, begin); });
    }
    over = true;
    writer.join();
    if (failure) std::rethrow_exception(failure);
    const double took_s = seconds_of(Clock::now() - begin);
    const double cpu_s = process_cpu_s() - before_s, sources_s = sources[0].cpu_s + sources[1].cpu_s;
    const auto end = Clock::now();
    sink->finish();
    const double end_s = seconds_of(Clock::now() - end);
    const std::uint64_t produced = cameras * pictures, dropped = sources[0].dropped + sources[1].dropped,
                        stored = sink->count(0) + sink->count(1);
    if (produced != stored + dropped)
        throw std::runtime_error{std::to_string(produced) + " produced, but " + std::to_string(stored) +
                                 " stored and " + std::to_string(dropped) + " dropped"};
    table.add({{"method", method},
               {"produced", static_cast<double>(produced), "", 9},
               {"stored", static_cast<double>(stored), "", 9},
               {"dropped", static_cast<double>(dropped), "", 9},
               {"peak backlog", 1e3 * written.backlog_s, "ms"},
               {"longest add", 1e3 * written.longest_s, "ms"},
               {"recording", (cpu_s - sources_s) / took_s, "cores"},
               {"its writer", written.cpu_s / took_s, "cores"},
               {"cameras", sources_s / took_s, "cores"},
               {"rate", static_cast<double>(stored * shape.bytes()) / took_s / 1e6, "MB/s"},
               {"end", 1e3 * end_s, "ms"},
               {"read back wrong", errors_of(*sink, scene)}});
    fs::remove_all(folder);
}

std::string option(int argc, char** argv, const char* name, const std::string& otherwise) {
    for (int i = 1; i + 1 < argc; ++i)
        if (std::strcmp(argv[i], name) == 0) return argv[i + 1];
    return otherwise;
}

}  // namespace
}  // namespace shaker

int main(int argc, char** argv) try {
    using namespace shaker;
    const int seconds = std::max(1, std::atoi(option(argc, argv, "--seconds", "20").c_str()));
    const fs::path folder =
        fs::path{option(argc, argv, "--folder", test::build_dir())} / "bench_frames_pictures";
    const Scene scene;
    bench::Table table;
    add_row<Segments>(table, "segments, O_DIRECT, blocks of 8 to 64", folder, seconds, scene);
    add_row<Chunks>(table, "H5Dwrite_chunk, SWMR, flush 0.5 s", folder, seconds, scene);
    table.print(argc, argv);
} catch (const std::exception& error) {
    std::fprintf(stderr, "bench_frames: %s\n", error.what());
    return 1;
}
