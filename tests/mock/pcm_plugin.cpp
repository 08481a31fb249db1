// PCM plug-in that libasound loads into its client: the client's side of a mock converter.
//
//   pcm_type.shaker_mock { lib "/.../shaker_mock_pcm.so" }
//   pcm.shaker { type shaker_mock  converter "/dev/shm/converter" }
//
// It behaves like a kernel PCM: frames can be taken back (rewind), the stream stops at stop_threshold,
// silence_size = boundary silences played frames, and the frames of a killed client stay.
#include <alsa/asoundlib.h>
#include <alsa/pcm_external.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <memory>
#include <vector>

#include "drivers/descriptor.hpp"
#include "tests/mock/converter_memory.hpp"
#include "tests/mock/sound/limits_plugin.hpp"

namespace {

using shaker::Descriptor;
using shaker::mock::ConverterMemory;
using Phase = ConverterMemory::Phase;

// A mapped file with a lock that makes this process its only client. The lock lives as long as a descriptor
// of this opening, in whatever process: the converter stops without it, as a kernel does when a card is
// closed.
class Mapping {
public:
    ~Mapping() {
        if (memory_ != nullptr) ::munmap(memory_, sizeof(ConverterMemory));
    }

    int open(const char* file) noexcept {
        fd_ = Descriptor{::open(file, O_RDWR | O_CLOEXEC)};
        if (fd_ < 0) return -errno;
        struct flock whole {};
        whole.l_type = F_WRLCK;
        whole.l_whence = SEEK_SET;
        if (::fcntl(fd_, F_OFD_SETLK, &whole) != 0) return -EBUSY;
        struct stat size {};
        if (::fstat(fd_, &size) != 0 || size.st_size != sizeof(ConverterMemory)) return -EINVAL;
        void* at = ::mmap(nullptr, sizeof(ConverterMemory), PROT_READ | PROT_WRITE, MAP_SHARED, fd_, 0);
        if (at == MAP_FAILED) return -errno;
        memory_ = static_cast<ConverterMemory*>(at);
        return memory_->ready.load(std::memory_order_acquire) == ConverterMemory::version ? 0 : -EINVAL;
    }
    [[nodiscard]] ConverterMemory& operator*() const noexcept { return *memory_; }
    [[nodiscard]] int descriptor() const noexcept { return fd_; }

private:
    Descriptor fd_;
    ConverterMemory* memory_ = nullptr;
};

struct Frame {
    std::int32_t first, second, third;
};

struct Plugin {
    snd_pcm_ioplug_t io{};
    Mapping mapping{};
    Descriptor timer{};
    std::vector<Frame> ring{};  // written frames, at frame number modulo buffer
    std::int64_t highest = 0;   // number of frames ever written to this stream
    std::int64_t position = 0;  // frames played at the last call of pointer()
    std::int64_t written = 0;   // application pointer without wrap
    snd_pcm_uframes_t boundary = 0, avail_min = 1;
    std::int64_t stop_threshold = 0;

    [[nodiscard]] ConverterMemory& memory() const noexcept { return *mapping; }
    [[nodiscard]] std::int64_t play_now() const noexcept {
        timespec t{};
        clock_gettime(CLOCK_MONOTONIC, &t);
        return memory().play_count(memory().due(std::int64_t{1'000'000'000} * t.tv_sec + t.tv_nsec));
    }
    [[nodiscard]] Phase phase() const noexcept { return ConverterMemory::phase(memory().state); }
    void change(Phase to) const noexcept { memory().state = ConverterMemory::changed(memory().state, to); }
    void end_stream(std::int64_t from, Phase to) const noexcept {
        change(to);
        memory().erase(from, std::max(memory().start + highest, from));
    }
    void set_timer(bool running) const noexcept;
    void follow_client() noexcept;
};

Plugin& plugin_of(snd_pcm_ioplug_t* io) { return *static_cast<Plugin*>(io->private_data); }

void Plugin::set_timer(bool running) const noexcept {
    const double ns = static_cast<double>(io.period_size) / memory().samples_per_ns();
    const auto whole = running ? static_cast<std::int64_t>(ns) : 0;
    const timespec period{.tv_sec = whole / 1'000'000'000, .tv_nsec = whole % 1'000'000'000};
    const itimerspec every{.it_interval = period, .it_value = period};
    ::timerfd_settime(timer, 0, &every, nullptr);
}

// libasound's application pointer wraps at the boundary and decreases when frames are taken back.
void Plugin::follow_client() noexcept {
    const auto wrap = static_cast<std::int64_t>(boundary);
    std::int64_t moved = (static_cast<std::int64_t>(io.appl_ptr) - written % wrap + wrap) % wrap;
    if (moved > wrap / 2) moved -= wrap;
    if (moved == 0) return;
    written += moved;
    memory().written = written;
}

int start(snd_pcm_ioplug_t* io) {
    Plugin& p = plugin_of(io);
    ConverterMemory& m = p.memory();
    if (m.unplugged) return -ENODEV;
    const std::int64_t first = p.play_now() + 1;
    m.start = first;
    for (std::int64_t i = 0; i < p.highest; ++i) {
        const Frame& f = p.ring[static_cast<std::size_t>(i) % p.ring.size()];
        m.put(first + i, f.first, f.second, f.third);
    }
    m.starts[m.start_count % ConverterMemory::starts_held] = first;
    ++m.start_count;
    p.change(Phase::running);
    p.set_timer(true);
    return 0;
}

int stop(snd_pcm_ioplug_t* io) {
    const Plugin& p = plugin_of(io);
    p.set_timer(false);
    if (p.phase() == Phase::running) p.end_stream(p.play_now(), Phase::idle);
    return 0;
}

int prepare(snd_pcm_ioplug_t* io) {
    Plugin& p = plugin_of(io);
    ConverterMemory& m = p.memory();
    if (m.unplugged) return -ENODEV;
    if (p.phase() == Phase::running) p.end_stream(p.play_now(), Phase::idle);
    if (p.phase() == Phase::ran_dry) p.end_stream(m.dry_at(), Phase::idle);
    p.highest = p.position = p.written = 0;
    m.written = 0;
    return 0;
}

snd_pcm_sframes_t pointer(snd_pcm_ioplug_t* io) {
    Plugin& p = plugin_of(io);
    ConverterMemory& m = p.memory();
    const auto shown = [&] {
        return static_cast<snd_pcm_sframes_t>(p.position % static_cast<std::int64_t>(p.boundary));
    };
    if (m.unplugged) {
        snd_pcm_ioplug_set_state(io, SND_PCM_STATE_DISCONNECTED);
        return shown();
    }
    const std::uint64_t state = m.state;
    if (ConverterMemory::phase(state) == Phase::idle) return shown();
    p.follow_client();
    const std::int64_t play = p.play_now();
    if (ConverterMemory::phase(state) == Phase::running && m.underrun.exchange(false)) {
        ++m.underrun_count;
        p.end_stream(play, Phase::ran_dry);
        return -EPIPE;
    }
    if (m.dry(state, play) || ConverterMemory::phase(state) == Phase::ran_dry) return -EPIPE;
    p.position = std::max(p.position, play - m.start);
    return shown();
}

// Consistent with the time stamp that libasound takes after pointer(): does not read a clock.
int delay(snd_pcm_ioplug_t* io, snd_pcm_sframes_t* frames) {
    const Plugin& p = plugin_of(io);
    if (p.memory().unplugged) return -ENODEV;
    const auto boundary = static_cast<std::int64_t>(p.boundary);
    *frames = (static_cast<std::int64_t>(io->appl_ptr) - p.position % boundary + boundary) % boundary;
    if (*frames > boundary / 2) *frames -= boundary;
    return 0;
}

// Left-justified code of a little-endian sample.
std::int32_t code_at(const std::uint8_t* at, snd_pcm_format_t format) {
    std::uint32_t code = 0;
    const int bytes = snd_pcm_format_physical_width(format) / 8;
    for (int i = 0; i < bytes; ++i) code |= std::uint32_t{at[i]} << (8 * i);
    return static_cast<std::int32_t>(code << (32 - snd_pcm_format_width(format)));
}

snd_pcm_sframes_t transfer(snd_pcm_ioplug_t* io, const snd_pcm_channel_area_t* areas,
                           snd_pcm_uframes_t offset, snd_pcm_uframes_t size) {
    Plugin& p = plugin_of(io);
    ConverterMemory& m = p.memory();
    if (m.unplugged) {
        snd_pcm_ioplug_set_state(io, SND_PCM_STATE_DISCONNECTED);
        return -ENODEV;
    }
    p.follow_client();
    const auto sample = [&](const snd_pcm_channel_area_t& area, snd_pcm_uframes_t i) {
        const std::size_t bit = area.first + (offset + i) * area.step;
        return code_at(static_cast<const std::uint8_t*>(area.addr) + bit / 8, io->format);
    };
    const bool running = p.phase() == Phase::running;
    const std::int64_t played = running ? p.play_now() : 0;
    for (snd_pcm_uframes_t i = 0; i < size; ++i) {
        const Frame f{sample(areas[0], i), sample(areas[1], i), io->channels > 2 ? sample(areas[2], i) : 0};
        const std::int64_t frame = p.written + static_cast<std::int64_t>(i);
        p.ring[static_cast<std::size_t>(frame) % p.ring.size()] = f;
        // Frames behind the converter's position are not played.
        if (running && m.start + frame >= played)
            m.stage(m.start + frame).put(m.start + frame, f.first, f.second, f.third);
    }
    const std::int64_t begins = p.written;
    p.written += static_cast<std::int64_t>(size);
    if (running) m.publish(std::max(played, m.start + begins), m.start + p.written);
    p.highest = std::max(p.highest, p.written);
    m.written = p.written;  // libasound moves its own pointer afterwards
    return static_cast<snd_pcm_sframes_t>(size);
}

int hw_params(snd_pcm_ioplug_t* io, snd_pcm_hw_params_t*) {
    Plugin& p = plugin_of(io);
    if (p.memory().unplugged) return -ENODEV;
    p.ring.assign(io->buffer_size, {});
    p.memory().buffer_frames = static_cast<std::int64_t>(io->buffer_size);
    return 0;
}

int sw_params(snd_pcm_ioplug_t* io, snd_pcm_sw_params_t* params) {
    Plugin& p = plugin_of(io);
    snd_pcm_uframes_t stop_threshold = 0, silence = 0;
    snd_pcm_sw_params_get_boundary(params, &p.boundary);
    snd_pcm_sw_params_get_avail_min(params, &p.avail_min);
    snd_pcm_sw_params_get_stop_threshold(params, &stop_threshold);
    snd_pcm_sw_params_get_silence_size(params, &silence);
    p.memory().plays_on =
        static_cast<std::int64_t>(stop_threshold) - static_cast<std::int64_t>(io->buffer_size);
    p.memory().silences = silence >= p.boundary;
    return 0;
}

// The first descriptor is the stream's, as for a kernel's PCM; the second one wakes.
int poll_descriptors_count(snd_pcm_ioplug_t* /*io*/) { return 2; }

int poll_descriptors(snd_pcm_ioplug_t* io, pollfd* fds, unsigned int space) {
    const Plugin& p = plugin_of(io);
    const pollfd all[] = {{.fd = p.mapping.descriptor(), .events = 0, .revents = 0},
                          {.fd = p.timer, .events = POLLIN, .revents = 0}};
    const unsigned count = std::min(space, 2U);
    std::copy_n(all, count, fds);
    return static_cast<int>(count);
}

int poll_revents(snd_pcm_ioplug_t* io, pollfd* fds, unsigned int count, unsigned short* events) {
    const Plugin& p = plugin_of(io);
    *events = 0;
    if (count != 2) return -EINVAL;
    std::uint64_t expirations = 0;
    if ((fds[1].revents & POLLIN) != 0 && ::read(p.timer, &expirations, sizeof expirations) < 0) return 0;
    const snd_pcm_sframes_t played = pointer(io);
    if (played < 0 || p.memory().unplugged) {
        *events = POLLERR | POLLOUT;
        return 0;
    }
    const auto room = static_cast<std::int64_t>(io->buffer_size) + p.position - p.written;
    if (room >= static_cast<std::int64_t>(p.avail_min)) *events = POLLOUT;
    return 0;
}

int close(snd_pcm_ioplug_t* io) {
    stop(io);
    const Plugin& p = plugin_of(io);
    if (p.phase() == Phase::ran_dry) --p.memory().underrun_count;  // it had reached its end
    const std::unique_ptr<Plugin> owned{&plugin_of(io)};
    return 0;
}

const snd_pcm_ioplug_callback_t callbacks = [] {
    snd_pcm_ioplug_callback_t c{};
    c.start = start;
    c.stop = stop;
    c.pointer = pointer;
    c.transfer = transfer;
    c.close = close;
    c.hw_params = hw_params;
    c.sw_params = sw_params;
    c.prepare = prepare;
    c.poll_descriptors_count = poll_descriptors_count;
    c.poll_descriptors = poll_descriptors;
    c.poll_revents = poll_revents;
    c.delay = delay;
    return c;
}();

// The file named by the key `converter`; null after reporting an error.
const char* converter_file(snd_config_t* conf) {
    const char* file = nullptr;
    snd_config_iterator_t i = nullptr, next = nullptr;
    snd_config_for_each(i, next, conf) {
        snd_config_t* entry = snd_config_iterator_entry(i);
        const char* key = nullptr;
        if (snd_config_get_id(entry, &key) < 0) continue;
        if (std::strcmp(key, "comment") == 0 || std::strcmp(key, "type") == 0 ||
            std::strcmp(key, "hint") == 0 || std::strcmp(key, "channels") == 0)
            continue;
        if (std::strcmp(key, "converter") != 0 || snd_config_get_string(entry, &file) < 0) {
            SNDERR("shaker_mock: only `converter \"file\"` is understood, not %s", key);
            return nullptr;
        }
    }
    if (file == nullptr) SNDERR("shaker_mock: `converter \"file\"` is missing");
    return file;
}

}  // namespace

extern "C" {

SND_PCM_PLUGIN_DEFINE_FUNC(shaker_mock) {
    static_cast<void>(root);
    if (stream != SND_PCM_STREAM_PLAYBACK) return -EINVAL;
    const char* file = converter_file(conf);
    if (file == nullptr) return -EINVAL;
    auto plugin = std::make_unique<Plugin>();
    if (const int error = plugin->mapping.open(file); error < 0) return error;
    if (plugin->memory().unplugged) return -ENODEV;
    plugin->timer = Descriptor{::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)};
    if (plugin->timer < 0) return -errno;
    // A killed client has left a stream: this one takes the device over.
    plugin->highest = plugin->memory().written + plugin->memory().buffer_frames;
    if (plugin->phase() != Phase::idle) plugin->end_stream(plugin->play_now(), Phase::idle);

    snd_pcm_ioplug_t& io = plugin->io;
    io.version = SND_PCM_IOPLUG_VERSION;
    io.name = "shaker mock converter";
    io.callback = &callbacks;
    io.private_data = plugin.get();
    io.poll_fd = plugin->timer;
    io.poll_events = POLLIN;
    io.flags = SND_PCM_IOPLUG_FLAG_MONOTONIC | SND_PCM_IOPLUG_FLAG_BOUNDARY_WA;
    if (const int error = snd_pcm_ioplug_create(&io, name, stream, mode); error < 0) return error;
    Plugin* owned_by_pcm = plugin.release();
    const int error =
        shaker::mock::constrain(&owned_by_pcm->io, conf, owned_by_pcm->memory().rate_hz, {2, 3, 8});
    if (error < 0) {
        snd_pcm_ioplug_delete(&owned_by_pcm->io);
        return error;
    }
    *pcmp = owned_by_pcm->io.pcm;
    return 0;
}

SND_PCM_PLUGIN_SYMBOL(shaker_mock)
}
