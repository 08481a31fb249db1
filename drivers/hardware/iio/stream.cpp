#include "drivers/hardware/iio/stream.hpp"

#include <iio.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <mutex>

#include "drivers/errors.hpp"
#include "drivers/hardware/iio/context.hpp"
#include "drivers/quantity.hpp"

namespace shaker::iio {
namespace {

constexpr double rate_tolerance = 0.01;  // largest relative difference between requested and actual rate
constexpr const char* clock_attribute = "current_timestamp_clock";

struct BufferEnd {
    void operator()(iio_buffer* buffer) const noexcept { iio_buffer_destroy(buffer); }
};
using BufferHandle = std::unique_ptr<iio_buffer, BufferEnd>;

std::string described(const iio_device* device) {
    const std::string name = iio_string(iio_device_get_name(device));
    return name.empty() ? iio_string(iio_device_get_id(device)) : name;
}

bool answers_to(const iio_device* device, const std::string& who) {
    return iio_string(iio_device_get_id(device)) == who || iio_string(iio_device_get_name(device)) == who ||
           iio_string(iio_device_get_label(device)) == who || iio_serial(device) == who;
}

IioChannel channel_of(const iio_channel* channel) {
    const iio_data_format* f = iio_channel_get_data_format(channel);
    return {{.bits = f->bits,
             .storage_bits = f->length,
             .shift = f->shift,
             .is_signed = f->is_signed,
             .big_endian = f->is_be},
            iio_channel_get_index(channel)};
}

}  // namespace

struct IioStream::Impl {
    IioSettings settings;
    IioContextHandle context;
    iio_device* device = nullptr;
    std::array<iio_channel*, 3> axes{};
    iio_channel* stamp = nullptr;
    IioFacts facts{};
    std::mutex mutex{};  // guards the pointer `buffer` and `cancelled`; not held while libiio waits
    BufferHandle buffer{};
    bool cancelled = false;

    explicit Impl(const IioSettings& s) : settings{s}, context{open_iio_context(s.uri)} {
        iio_context_set_timeout(context.get(), static_cast<unsigned>(std::lround(1e3 * s.timeout_s)));
        find_device();
        facts.name = described(device) + " at " + s.uri;
        find_channels();
        set_trigger();
        set_rate();
        set_clock();
        set_buffers();
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    ~Impl() { end_buffer(); }

    void find_device();
    void find_channels();
    void set_trigger();
    void set_rate();
    void set_clock();
    void set_buffers();
    void end_buffer() noexcept;
    [[noreturn]] void fail(const std::string& what) const { throw DeviceError{facts.name + ": " + what}; }
};

void IioStream::Impl::find_device() {
    std::vector<iio_device*> found;
    std::string there;
    for (unsigned i = 0; i < iio_context_get_devices_count(context.get()); ++i) {
        iio_device* candidate = iio_context_get_device(context.get(), i);
        if (iio_device_is_trigger(candidate)) continue;
        there += (there.empty() ? "" : ", ") + described(candidate);
        const bool fits = !settings.device.empty()
                              ? answers_to(candidate, settings.device)
                              : std::ranges::all_of(settings.channels, [&](const std::string& id) {
                                    return iio_device_find_channel(candidate, id.c_str(), false) != nullptr;
                                });
        if (fits) found.push_back(candidate);
    }
    const std::string asked =
        settings.device.empty() ? "with the requested channels" : "\"" + settings.device + "\"";
    if (found.empty())
        throw DeviceError{settings.uri + ": no device " + asked + "; found " +
                          (there.empty() ? "none" : there)};
    if (found.size() > 1)
        throw DeviceError{settings.uri + ": " + std::to_string(found.size()) + " devices " + asked +
                          "; set `device` to one id, label or serial number"};
    device = found.front();
}

void IioStream::Impl::find_channels() {
    for (unsigned i = 0; i < iio_device_get_channels_count(device); ++i)
        iio_channel_disable(iio_device_get_channel(device, i));
    std::vector<IioChannel> channels(settings.channels.size());
    for (std::size_t k = 0; k < channels.size(); ++k) {
        const std::string& id = settings.channels[k];
        axes[k] = iio_device_find_channel(device, id.c_str(), false);
        if (axes[k] == nullptr) fail("no input channel \"" + id + "\"");
        if (!iio_channel_is_scan_element(axes[k])) fail("channel \"" + id + "\" cannot be buffered");
        channels[k] = channel_of(axes[k]);
        if (!fits_counts(channels[k].format) || iio_channel_get_data_format(axes[k])->repeat > 1)
            fail("channel \"" + id + "\" does not fit into 32 bits");
        const auto scale = iio_number(device, axes[k], "scale");
        if (!scale || *scale == 0) fail("channel \"" + id + "\" has no scale");
        facts.mps2_per_count[k] = *scale;
        facts.offset_counts[k] = iio_number(device, axes[k], "offset").value_or(0);
        iio_channel_enable(axes[k]);
    }
    facts.stamps = settings.stamps;
    stamp = iio_device_find_channel(device, "timestamp", false);
    if (facts.stamps != IioStamps::none && (stamp == nullptr || !iio_channel_is_scan_element(stamp))) {
        facts.stamps = IioStamps::none;
        facts.notes.emplace_back("no stamps: lost samples are detected only when the connection breaks");
    }
    if (facts.stamps == IioStamps::none) stamp = nullptr;
    if (stamp != nullptr) iio_channel_enable(stamp);
    facts.scan = stamp != nullptr ? lay_out_scan(channels, channel_of(stamp)) : lay_out_scan(channels, {});
}

void IioStream::Impl::set_trigger() {
    if (settings.trigger.empty()) return;
    const iio_device* trigger = iio_context_find_device(context.get(), settings.trigger.c_str());
    if (trigger == nullptr || !iio_device_is_trigger(trigger))
        fail("there is no trigger \"" + settings.trigger + "\"");
    if (const int rc = iio_device_set_trigger(device, trigger); rc < 0)
        fail("trigger \"" + settings.trigger + "\": " + iio_words(rc));
}

void IioStream::Impl::set_rate() {
    const IioRate place = iio_rate(device, axes[0]);
    // Some kernel drivers have the attribute but do not support it: the rate is 0 or cannot be read.
    const auto read_rate = [&] {
        const std::optional<double> hz = place.hz();
        return hz && *hz > 0 ? hz : std::nullopt;
    };
    if (settings.rate_hz && read_rate()) {
        const std::string text = to_text(*settings.rate_hz);
        const long rc = place.set(text);
        const auto choice = place.choice();
        if (rc < 0)
            fail("rate of " + text + " Hz: " + iio_words(static_cast<int>(rc)) +
                 (choice ? "; available: " + *choice : ""));
    }
    const std::optional<double> rate = read_rate();
    if (!rate && !settings.rate_hz) fail("the device does not report its rate; set rate_hz");
    if (!rate) facts.notes.emplace_back("the device does not report its rate: rate_hz is used");
    facts.rate_hz = rate ? *rate : *settings.rate_hz;
    if (settings.rate_hz && std::abs(facts.rate_hz / *settings.rate_hz - 1) > rate_tolerance)
        fail("rate of " + to_text(*settings.rate_hz) + " Hz was requested, the device set " +
             to_text(facts.rate_hz) + " Hz");
}

void IioStream::Impl::set_clock() {
    if (stamp == nullptr) return;
    const auto rc = iio_device_attr_write(device, clock_attribute, "monotonic");
    const auto clock = iio_text(device, nullptr, clock_attribute);
    if (clock == "monotonic" || facts.stamps != IioStamps::host) return;
    facts.stamps = IioStamps::device;
    facts.notes.push_back("its stamps do not use the monotonic clock (" +
                          (clock ? "they use " + *clock : iio_words(static_cast<int>(rc))) +
                          "): the time of arrival is used");
}

void IioStream::Impl::set_buffers() {
    // A quarter of the time-out, because the far side of a network waits only half as long as this one.
    const double most = std::max(1.0, facts.rate_hz * settings.timeout_s / 4);
    facts.buffer_samples = static_cast<int>(std::min<double>(settings.buffer_samples, most));
    if (facts.buffer_samples < settings.buffer_samples)
        facts.notes.push_back("buffers of " + std::to_string(facts.buffer_samples) +
                              " samples: larger ones would exceed timeout_s");
    const int rc =
        iio_device_set_kernel_buffers_count(device, static_cast<unsigned>(settings.kernel_buffers));
    if (rc < 0) facts.notes.push_back("kernel_buffers: " + iio_words(rc));
}

void IioStream::Impl::end_buffer() noexcept {
    BufferHandle ended;
    const std::scoped_lock lock{mutex};
    ended.swap(buffer);
}

IioStream::IioStream(const IioSettings& settings) : impl_{std::make_unique<Impl>(settings)} {}
IioStream::~IioStream() = default;

const IioFacts& IioStream::facts() const noexcept { return impl_->facts; }

void IioStream::start() {
    Impl& s = *impl_;
    s.end_buffer();
    const auto samples = static_cast<std::size_t>(s.facts.buffer_samples);
    BufferHandle fresh{iio_device_create_buffer(s.device, samples, false)};
    if (!fresh) s.fail("buffer of " + std::to_string(samples) + " samples: " + iio_words(errno));
    // A buffer has its own connection, which may reach another server by now.
    if (iio_number(s.device, s.axes[0], "scale") != s.facts.mps2_per_count[0])
        s.fail("does not answer as when it was opened");
    const std::scoped_lock lock{s.mutex};
    if (s.cancelled) iio_buffer_cancel(fresh.get());
    s.buffer = std::move(fresh);
}

int IioStream::refill(std::span<const std::byte>& samples) noexcept {
    iio_buffer* buffer = impl_->buffer.get();
    samples = {};
    if (buffer == nullptr) return -EBADF;
    const ssize_t size = iio_buffer_refill(buffer);
    if (size <= 0) return size == 0 ? -EPIPE : static_cast<int>(size);
    // Other readers of the device may have enabled channels: the layout is then unknown.
    if (iio_buffer_step(buffer) != static_cast<std::ptrdiff_t>(impl_->facts.scan.size)) return -EPROTO;
    samples = {static_cast<const std::byte*>(iio_buffer_start(buffer)), static_cast<std::size_t>(size)};
    return 0;
}

void IioStream::cancel() noexcept {
    const std::scoped_lock lock{impl_->mutex};
    impl_->cancelled = true;
    if (impl_->buffer) iio_buffer_cancel(impl_->buffer.get());
}

}  // namespace shaker::iio
