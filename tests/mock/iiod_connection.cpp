#include "tests/mock/iiod_connection.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <boost/asio/buffer.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>

namespace shaker::mock {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {
constexpr std::size_t longest_line = 1024, longest_value = 65536;  // bytes
constexpr std::size_t most_buffer_samples = 1 << 20;
}  // namespace

IiodConnection::IiodConnection(asio::ip::tcp::socket socket, IiodShared& shared)
    : socket_{std::move(socket)}, deadline_{socket_.get_executor()}, shared_{shared} {
    error_code ignored;
    socket_.set_option(asio::ip::tcp::no_delay{true}, ignored);
}

void IiodConnection::receive() {
    asio::async_read_until(socket_, asio::dynamic_buffer(in_, longest_line), '\n',
                           [self = shared_from_this()](error_code error, std::size_t length) {
                               if (error) return self->close();
                               const IiodCommand command = parse_iiod_command(self->in_.substr(0, length));
                               self->in_.erase(0, length);
                               if (command.verb == IiodVerb::exit) return self->close();
                               if (command.verb == IiodVerb::write) return self->receive_value(command);
                               self->execute(command);
                               self->receive();
                           });
}

void IiodConnection::receive_value(IiodCommand command) {
    if (command.number > longest_value) return close();
    const std::size_t size = command.number, missing = size - std::min(size, in_.size());
    asio::async_read(
        socket_, asio::dynamic_buffer(in_), asio::transfer_exactly(missing),
        [self = shared_from_this(), command = std::move(command)](error_code error, std::size_t) {
            if (error) return self->close();
            const std::string value = self->in_.substr(0, command.number);
            self->in_.erase(0, command.number);
            const int rc = self->shared_.device.write(command, value);
            self->shared_.rate_hz = self->shared_.device.rate_hz();
            self->reply(rc < 0 ? rc : static_cast<std::int64_t>(command.number));
            self->receive();
        });
}

void IiodConnection::execute(const IiodCommand& command) {
    IiodDevice& device = shared_.device;
    const bool ours = device.is_device(command.device), known = ours || device.is_trigger(command.device);
    std::string value;
    switch (command.verb) {
        case IiodVerb::none:
            return;
        case IiodVerb::print:
            value = device.xml();
            return put(std::to_string(value.size()) + "\n" + value + "\n");
        case IiodVerb::version:
            return put("0.24.mockiio\n");
        case IiodVerb::timeout:
            shared_.timeout_ms = command.number;
            return reply(0);
        case IiodVerb::read:
            if (const int rc = device.read(command, value); rc < 0) return reply(rc);
            value += '\0';
            return put(std::to_string(value.size()) + "\n" + value + "\n");
        case IiodVerb::get_trigger:
            if (!ours || !shared_.triggered) return reply(known ? 0 : -ENODEV);
            value = device.trigger_name();
            return put(std::to_string(value.size()) + "\n" + value + "\n");
        case IiodVerb::set_trigger:
            if (!known) return reply(-ENODEV);
            if (!command.trigger.empty() && !device.is_trigger(command.trigger)) return reply(-ENOENT);
            shared_.triggered = !command.trigger.empty();
            return reply(0);
        case IiodVerb::set_buffers:
            if (!known || command.number < 1) return reply(known ? -EINVAL : -ENODEV);
            shared_.buffers = command.number;
            return reply(0);
        case IiodVerb::open:
            return open(command);
        case IiodVerb::read_buffer:
            return read_buffer(command);
        case IiodVerb::close:
            if (!buffer_) return reply(known ? -EBADF : -ENODEV);
            drop_buffer();
            return reply(0);
        default:
            return reply(-EINVAL);
    }
}

void IiodConnection::open(const IiodCommand& command) {
    IiodDevice& device = shared_.device;
    if (!device.is_device(command.device))
        return reply(device.is_trigger(command.device) ? -EINVAL : -ENODEV);
    Buffer buffer;
    if (buffer_) return reply(-EBUSY);
    if (!decode_iiod_mask(command.mask, buffer.mask) || (buffer.mask & ~IiodDevice::all_channels) != 0 ||
        buffer.mask == 0 || command.number < 1 || command.number > most_buffer_samples)
        return reply(-EINVAL);
    buffer.samples = command.number;
    buffer.capacity =
        device.fifo() > 0 ? device.fifo() : std::clamp<std::size_t>(shared_.buffers, 1, 64) * buffer.samples;
    buffer_ = std::move(buffer);
    reply(0);
}

void IiodConnection::read_buffer(const IiodCommand& command) {
    if (!shared_.device.is_device(command.device)) return reply(-ENODEV);
    if (!buffer_) return reply(-EBADF);
    if (buffer_->error < 0) return end_buffer(buffer_->error);
    if (buffer_->wanted > 0) return reply(-EBUSY);
    const std::size_t size = shared_.device.sample_size(buffer_->mask);
    buffer_->wanted = command.number / size;
    buffer_->short_end = command.number % size != 0;
    buffer_->mask_due = true;
    if (buffer_->wanted == 0) return reply(0);
    await_samples();
    serve();
}

void IiodConnection::await_samples() {
    if (shared_.timeout_ms == 0) return;
    deadline_.expires_after(std::chrono::milliseconds{shared_.timeout_ms});
    deadline_.async_wait([self = shared_from_this()](error_code error) {
        if (!error && self->buffer_ && self->buffer_->wanted > 0) self->end_buffer(-ETIMEDOUT);
    });
}

void IiodConnection::offer(const IiodSample& sample) {
    if (buffer_->fifo.size() >= buffer_->capacity) {
        ++shared_.overflowed;
        ++buffer_->overflowed_last;
    } else {
        buffer_->fifo.push_back({sample, std::exchange(buffer_->overflowed_last, 0)});
    }
}

void IiodConnection::serve() {
    while (buffer_ && buffer_->wanted > 0) {
        const std::size_t piece = std::min({buffer_->wanted, buffer_->samples, buffer_->capacity});
        if (buffer_->fifo.size() < piece) return;
        send_piece(piece);
    }
}

void IiodConnection::send_piece(std::size_t samples) {
    Buffer& b = *buffer_;
    std::string head = std::to_string(samples * shared_.device.sample_size(b.mask)) + "\n";
    if (std::exchange(b.mask_due, false)) head += encode_iiod_mask(b.mask) + "\n";
    out_.insert(out_.end(), head.begin(), head.end());
    for (std::size_t i = 0; i < samples; ++i) shared_.device.encode(b.fifo[i].sample, b.mask, out_);
    b.fifo.erase(b.fifo.begin(), b.fifo.begin() + static_cast<std::ptrdiff_t>(samples));
    out_samples_ += samples;
    b.wanted -= samples;
    deadline_.cancel();
    if (b.wanted > 0)
        await_samples();
    else if (b.short_end)
        return reply(0);
    send();
}

void IiodConnection::fail(int error) {
    if (!buffer_) return;
    if (buffer_->wanted > 0)
        end_buffer(error);
    else
        buffer_->error = error;
}

void IiodConnection::end_buffer(int error) {
    drop_buffer();
    reply(error);
}

void IiodConnection::drop_buffer() {
    deadline_.cancel();
    // Losses that no later sample could show to the client are counted as unread.
    std::uint64_t untold = buffer_->overflowed_last;
    for (const Held& held : buffer_->fifo) untold += held.overflowed_before;
    shared_.overflowed -= untold;
    shared_.unread += buffer_->fifo.size() + untold;
    buffer_.reset();
}

void IiodConnection::put(const std::string& text) {
    out_.insert(out_.end(), text.begin(), text.end());
    send();
}

void IiodConnection::send() {
    if (sending_ || out_.empty() || shared_.silent || closed()) return;
    sending_ = true;
    leaving_.swap(out_);
    leaving_samples_ = std::exchange(out_samples_, 0);
    asio::async_write(socket_, asio::buffer(leaving_),
                      [self = shared_from_this()](error_code error, std::size_t) {
                          self->sending_ = false;
                          self->leaving_.clear();
                          auto& tally = error ? self->shared_.unread : self->shared_.served;
                          tally += self->leaving_samples_;
                          if (error) return self->close();
                          self->send();
                      });
}

void IiodConnection::close() {
    if (buffer_) drop_buffer();
    shared_.unread += std::exchange(out_samples_, 0);
    error_code ignored;
    socket_.close(ignored);
    deadline_.cancel();
}

}  // namespace shaker::mock
