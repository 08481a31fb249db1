#include "tests/mock/converter.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <fstream>
#include <mutex>

#include "drivers/errors.hpp"
#include "tests/mock/converter_memory.hpp"

namespace shaker::mock {

namespace {

constexpr double full_scale = 2147483648.0;  // of a left-justified code

std::int64_t now_ns() {
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return std::int64_t{1'000'000'000} * t.tv_sec + t.tv_nsec;
}

struct OpenMemory {
    int file = -1;
    ConverterMemory* memory = nullptr;
};
OpenMemory create_memory(const std::filesystem::path& file) {
    const auto fail = [&](const char* what) -> void {
        throw DeviceError{"mock converter: " + file.string() + ": " + what + ": " + std::strerror(errno)};
    };
    const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0) fail("cannot be created");
    const bool sized = ::ftruncate(fd, sizeof(ConverterMemory)) == 0;
    void* at = sized ? ::mmap(nullptr, sizeof(ConverterMemory), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0)
                     : MAP_FAILED;
    const int error = errno;
    if (at == MAP_FAILED) {
        ::close(fd);
        errno = error;
        fail("cannot be mapped");
    }
    return {fd, static_cast<ConverterMemory*>(at)};
}

// True if a process has the descriptor with which a client opened the file.
bool has_client(int file) noexcept {
    struct flock whole {};
    whole.l_type = F_WRLCK;
    whole.l_whence = SEEK_SET;
    return ::fcntl(file, F_OFD_GETLK, &whole) != 0 || whole.l_type != F_UNLCK;
}

}  // namespace

struct Converter::State {
    std::filesystem::path file;
    OpenMemory open;
    ConverterMemory& memory{*open.memory};
    std::ofstream log{};
    std::vector<std::array<std::int32_t, 2>> logged{};
    std::atomic<std::int64_t> taken = 0;
    std::atomic<std::uint64_t> frames = 0, replayed = 0, missed = 0;
    mutable std::mutex mutex{};  // guards `starts`
    std::vector<std::int64_t> starts{};

    std::array<std::int32_t, 3> sample(std::int64_t timeline);
    std::array<std::int32_t, 3> from_stream(std::int64_t play);
    void note_starts(std::int64_t timeline, std::int64_t play);
};

// A client that waits for a processor announces its start after samples behind it were taken.
void Converter::State::note_starts(std::int64_t timeline, std::int64_t play) {
    while (starts.size() < memory.start_count.load(std::memory_order_acquire)) {
        const std::int64_t first = memory.starts[starts.size() % ConverterMemory::starts_held];
        if (first > play) return;
        const std::scoped_lock lock{mutex};
        starts.push_back(timeline - (play - first));
    }
}

std::array<std::int32_t, 3> Converter::State::sample(std::int64_t timeline) {
    const std::int64_t play = memory.play_count(timeline);
    if (play == memory.play_count(timeline + 1)) return {};  // halted
    note_starts(timeline, play);
    return memory.unplugged ? std::array<std::int32_t, 3>{} : from_stream(play);
}

std::array<std::int32_t, 3> Converter::State::from_stream(std::int64_t play) {
    const std::uint64_t state = memory.state;
    const bool dry = memory.dry(state, play);
    const ConverterSlot& slot = memory.heard(play);
    const std::int64_t index = slot.index.load(std::memory_order_acquire);
    if (index > play) ++missed;
    if (dry) return {};
    if (index == play) {
        ++frames;
        return {slot.first, slot.second, slot.third};
    }
    // No new samples: a converter that reads a ring in memory repeats its content.
    const std::int64_t round = memory.buffer_frames;
    if (ConverterMemory::phase(state) != ConverterMemory::Phase::running || memory.silences ||
        play - round < memory.start)
        return {};
    const ConverterSlot& old = memory.slot(play - round);
    if (old.index != play - round) return {};
    ++replayed;
    memory.put(play, old.first, old.second, old.third);
    return {old.first, old.second, old.third};
}

Converter::Converter(const std::filesystem::path& file, double rate_hz, double ppm,
                     const std::filesystem::path& log)
    : state_{new State{.file = file, .open = create_memory(file)}} {
    ConverterMemory& m = state_->memory;
    m.rate_hz = rate_hz;
    m.ppm = ppm;
    m.epoch_ns = now_ns();
    for (ConverterSlot& slot : m.slots) slot.index.store(ConverterSlot::none, std::memory_order_relaxed);
    m.ready.store(ConverterMemory::version, std::memory_order_release);
    if (log.empty()) return;
    state_->log.open(log, std::ios::binary);
    if (!state_->log) throw DeviceError{"mock converter: " + log.string() + ": cannot be written"};
}

Converter::~Converter() {
    ::munmap(&state_->memory, sizeof(ConverterMemory));
    ::close(state_->open.file);
    std::error_code ignored;
    std::filesystem::remove(state_->file, ignored);
}

std::int64_t Converter::due(HostTime now) const noexcept {
    return state_->memory.due(now.time_since_epoch().count());
}

HostTime Converter::time_of(std::int64_t sample) const noexcept {
    const double after_ns = static_cast<double>(sample) / state_->memory.samples_per_ns();
    return HostTime{std::chrono::nanoseconds{state_->memory.epoch_ns + std::llround(after_ns)}};
}

std::int64_t Converter::taken() const noexcept { return state_->taken; }

void Converter::take(std::span<double> first, std::span<double> second, std::span<double> third) {
    State& s = *state_;
    s.logged.clear();
    if (ConverterMemory::phase(s.memory.state) == ConverterMemory::Phase::running && !has_client(s.open.file))
        s.memory.close(s.memory.play_count(s.taken));
    for (std::size_t i = 0; i < first.size(); ++i) {
        const auto codes = s.sample(s.taken);
        ++s.taken;
        first[i] = codes[0] / full_scale;
        second[i] = codes[1] / full_scale;
        if (!third.empty()) third[i] = codes[2] / full_scale;
        if (s.log.is_open()) s.logged.push_back({codes[0], codes[1]});
    }
    if (!s.logged.empty()) {
        const auto bytes = static_cast<std::streamsize>(s.logged.size() * sizeof s.logged[0]);
        s.log.write(reinterpret_cast<const char*>(s.logged.data()), bytes).flush();
    }
}

void Converter::cause_underrun() noexcept { state_->memory.underrun = true; }
void Converter::unplug() noexcept { state_->memory.unplugged = true; }
void Converter::plug() noexcept { state_->memory.unplugged = false; }

void Converter::stall(Seconds duration) noexcept {
    ConverterMemory& m = state_->memory;
    const std::size_t n = m.stall_count;
    if (n == ConverterMemory::stalls_held) return;
    const std::int64_t from = m.due(now_ns());
    const auto length = static_cast<std::int64_t>(duration.count() * m.rate_hz);
    const std::int64_t earlier = n > 0 ? m.stalls[n - 1].until.load() : 0;  // halts follow each other
    m.stalls[n].from = std::max(from, earlier);
    m.stalls[n].until = m.stalls[n].from + length;
    m.stall_count.store(n + 1, std::memory_order_release);
}

ConverterCounts Converter::counts() const noexcept {
    return {.frames = state_->frames,
            .streams = state_->memory.start_count,
            .underruns = state_->memory.underrun_count,
            .replayed = state_->replayed,
            .missed = state_->missed};
}

std::vector<std::int64_t> Converter::stream_starts() const {
    const std::scoped_lock lock{state_->mutex};
    return state_->starts;
}

}  // namespace shaker::mock
