// PCM plug-in that libasound loads into its client: the client's side of a mock line input.
//
//   pcm_type.shaker_mock_line { lib "/.../shaker_mock_pcm.so" }
//   pcm.line { type shaker_mock_line  input "/dev/shm/line" }
#include <alsa/asoundlib.h>
#include <alsa/pcm_external.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <memory>

#include "drivers/descriptor.hpp"
#include "tests/mock/sound/limits_plugin.hpp"
#include "tests/mock/sound/line_memory.hpp"

namespace {

using shaker::Descriptor;
using shaker::mock::LineMemory;

struct Line {
    snd_pcm_ioplug_t io{};
    LineMemory* memory = nullptr;
    Descriptor timer{};
    std::int64_t start = 0;  // sample of the stream's frame 0
    std::int64_t read = 0;   // frames
    bool running = false;
    snd_pcm_uframes_t boundary = 0;

    ~Line() {
        if (memory != nullptr) ::munmap(memory, sizeof(LineMemory));
    }
    [[nodiscard]] std::int64_t now() const noexcept {
        timespec t{};
        clock_gettime(CLOCK_MONOTONIC, &t);
        return memory->due(std::int64_t{1'000'000'000} * t.tv_sec + t.tv_nsec);
    }
    void set_timer(bool on) const noexcept {
        const auto ns =
            on ? static_cast<long>(1e9 * static_cast<double>(io.period_size) / memory->nominal_hz) : 0;
        const timespec period{.tv_sec = 0, .tv_nsec = ns};
        const itimerspec every{.it_interval = period, .it_value = period};
        ::timerfd_settime(timer, 0, &every, nullptr);
    }
};

Line& line_of(snd_pcm_ioplug_t* io) { return *static_cast<Line*>(io->private_data); }

int line_start(snd_pcm_ioplug_t* io) {
    Line& l = line_of(io);
    if (l.memory->unplugged) return -ENODEV;
    l.start = l.now();
    l.read = 0;
    l.running = true;
    l.set_timer(true);
    return 0;
}

int line_stop(snd_pcm_ioplug_t* io) {
    Line& l = line_of(io);
    l.set_timer(false);
    l.running = false;
    return 0;
}

int line_prepare(snd_pcm_ioplug_t* io) {
    Line& l = line_of(io);
    l.running = false;
    l.read = 0;
    return l.memory->unplugged ? -ENODEV : 0;
}

snd_pcm_sframes_t line_pointer(snd_pcm_ioplug_t* io) {
    Line& l = line_of(io);
    if (l.memory->unplugged) {
        snd_pcm_ioplug_set_state(io, SND_PCM_STATE_DISCONNECTED);
        return -ENODEV;
    }
    if (!l.running) return 0;
    const std::int64_t recorded = l.now() - l.start;
    if (l.memory->overrun.exchange(false) || recorded - l.read > static_cast<std::int64_t>(io->buffer_size)) {
        l.running = false;
        return -EPIPE;
    }
    return static_cast<snd_pcm_sframes_t>(recorded % static_cast<std::int64_t>(l.boundary));
}

void put(std::uint8_t* at, std::int32_t code, snd_pcm_format_t format) {
    const int bytes = snd_pcm_format_physical_width(format) / 8;
    const auto value = static_cast<std::uint32_t>(code >> (32 - snd_pcm_format_width(format)));
    for (int i = 0; i < bytes; ++i) at[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

snd_pcm_sframes_t line_transfer(snd_pcm_ioplug_t* io, const snd_pcm_channel_area_t* areas,
                                snd_pcm_uframes_t offset, snd_pcm_uframes_t size) {
    Line& l = line_of(io);
    for (snd_pcm_uframes_t i = 0; i < size; ++i) {
        const LineMemory::Frame& frame = l.memory->frame(l.start + l.read + static_cast<std::int64_t>(i));
        for (unsigned k = 0; k < io->channels; ++k) {
            const std::size_t bit = areas[k].first + (offset + i) * areas[k].step;
            put(static_cast<std::uint8_t*>(areas[k].addr) + bit / 8,
                k < frame.size() ? frame.at(k).load() : 0, io->format);
        }
    }
    l.read += static_cast<std::int64_t>(size);
    return static_cast<snd_pcm_sframes_t>(size);
}

int line_sw_params(snd_pcm_ioplug_t* io, snd_pcm_sw_params_t* params) {
    return snd_pcm_sw_params_get_boundary(params, &line_of(io).boundary);
}

int line_revents(snd_pcm_ioplug_t* io, pollfd* fds, unsigned int count, unsigned short* events) {
    const Line& l = line_of(io);
    std::uint64_t expirations = 0;
    *events = 0;
    if (count != 1) return -EINVAL;
    if ((fds[0].revents & POLLIN) != 0 && ::read(l.timer, &expirations, sizeof expirations) < 0) return 0;
    if (l.memory->unplugged)
        *events = POLLERR | POLLIN;
    else if (l.now() - l.start > l.read)
        *events = POLLIN;
    return 0;
}

int line_close(snd_pcm_ioplug_t* io) {
    const std::unique_ptr<Line> owned{&line_of(io)};
    return 0;
}

const snd_pcm_ioplug_callback_t line_callbacks = [] {
    snd_pcm_ioplug_callback_t c{};
    c.start = line_start;
    c.stop = line_stop;
    c.pointer = line_pointer;
    c.transfer = line_transfer;
    c.close = line_close;
    c.sw_params = line_sw_params;
    c.prepare = line_prepare;
    c.poll_revents = line_revents;
    return c;
}();

// The file named by the key `input`; null without it.
const char* input_file(snd_config_t* conf) {
    snd_config_t* entry = nullptr;
    const char* file = nullptr;
    if (snd_config_search(conf, "input", &entry) < 0 || snd_config_get_string(entry, &file) < 0)
        SNDERR("shaker_mock_line: `input \"file\"` is missing");
    return file;
}

}  // namespace

extern "C" {

SND_PCM_PLUGIN_DEFINE_FUNC(shaker_mock_line) {
    static_cast<void>(root);
    const char* file = input_file(conf);
    if (stream != SND_PCM_STREAM_CAPTURE || file == nullptr) return -EINVAL;
    auto line = std::make_unique<Line>();
    const Descriptor fd{::open(file, O_RDWR | O_CLOEXEC)};
    if (fd < 0) return -errno;
    void* at = ::mmap(nullptr, sizeof(LineMemory), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (at == MAP_FAILED) return -errno;
    line->memory = static_cast<LineMemory*>(at);
    if (line->memory->ready.load(std::memory_order_acquire) != LineMemory::version) return -EINVAL;
    if (line->memory->unplugged) return -ENODEV;
    line->timer = Descriptor{::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)};
    if (line->timer < 0) return -errno;
    snd_pcm_ioplug_t& io = line->io;
    io.version = SND_PCM_IOPLUG_VERSION;
    io.name = "shaker mock line input";
    io.callback = &line_callbacks;
    io.private_data = line.get();
    io.poll_fd = line->timer;
    io.poll_events = POLLIN;
    io.flags = SND_PCM_IOPLUG_FLAG_MONOTONIC | SND_PCM_IOPLUG_FLAG_BOUNDARY_WA;
    if (const int error = snd_pcm_ioplug_create(&io, name, stream, mode); error < 0) return error;
    Line* owned_by_pcm = line.release();
    if (const int error =
            shaker::mock::constrain(&owned_by_pcm->io, conf, owned_by_pcm->memory->nominal_hz, {2, 8});
        error < 0) {
        snd_pcm_ioplug_delete(&owned_by_pcm->io);
        return error;
    }
    *pcmp = owned_by_pcm->io.pcm;
    return 0;
}

SND_PCM_PLUGIN_SYMBOL(shaker_mock_line)
}
