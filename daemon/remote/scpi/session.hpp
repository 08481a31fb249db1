#pragma once
// One client: bytes in, bytes out, its status and errors. No sockets, no threads, no clock.
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/remote/scpi/arguments.hpp"
#include "daemon/remote/scpi/command_tree.hpp"
#include "daemon/remote/scpi/control_lock.hpp"
#include "daemon/remote/scpi/framer.hpp"
#include "daemon/remote/scpi/instrument.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/status_model.hpp"

namespace shaker::scpi {

/// What all sessions share; it outlives them.
struct Shared {
    const CommandTree& tree;
    Instrument& instrument;
    DeviceStatus& status;
    ControlLock& lock;
};

/// A message ends with LF, so does a reply. An error in what a message says (-1xx) drops the rest of it; any
/// other error ends its unit only. Behind *WAI and *OPC? input is withheld until the instrument is done; an
/// urgent command (ABORt) in it runs at once and drops all that was withheld in front of it.
class Session {
public:
    static constexpr std::size_t input_limit = 65536;      // bytes of one message, and of what is withheld
    static constexpr std::size_t output_limit = 1U << 20;  // bytes of replies that were not sent

    /// `name` is told to other clients as the holder of control: the client's address.
    Session(Shared shared, std::string name);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// Bytes as they come, in pieces of any size.
    void feed(std::string_view bytes);
    /// Goes on with what waits as soon as the instrument is done. To be called when it may be, and often.
    void poll();
    /// The client sends no more. What it left incomplete is not executed: it is -420 where it asks for
    /// something.
    void finish();
    [[nodiscard]] bool waiting() const noexcept { return pause_.has_value(); }

    /// Replies to send; sent() says how many bytes of them are.
    [[nodiscard]] std::string_view output() const noexcept;
    void sent(std::size_t bytes);

    /// An error of the device, or a trip: all sessions are told.
    void report(Code code, std::string_view detail) { status_.report(code, detail); }
    [[nodiscard]] std::uint64_t reported() const noexcept { return status_.reported(); }
    /// After ABORt of another session: what this one withholds was meant for before it. -200 tells what was
    /// lost.
    void drop_withheld();

    // For handlers.
    [[nodiscard]] const Shared& shared() const noexcept { return shared_; }
    [[nodiscard]] StatusModel& status() noexcept { return status_; }
    [[nodiscard]] Format& format() noexcept { return format_; }
    [[nodiscard]] const std::string& name() const noexcept { return name_; }
    [[nodiscard]] std::uint8_t status_byte() noexcept;
    void complete_operation();                          // *OPC
    void forget_operation() noexcept { opc_ = false; }  // *CLS, *RST
    /// *WAI, *OPC?, READ?: what follows is withheld until `over`, which poll() asks; then `reply` writes, if
    /// there is one, or throws as a query may.
    struct Pause {
        std::function<bool()> over;
        std::function<void(Reply&)> reply;
    };
    void pause(Pause pause) { pause_ = std::move(pause); }
    /// Error -203 unless this session may change what the bench does.
    void require_control() const;

private:
    void accept(Text message);
    void run_message(Text message);
    void run_units(Text rest);
    bool run_unit(Text& rest, Path& path, bool behind_blank);
    void run_values(const Found& found, Text& rest);
    void execute(const Found& found, std::span<const Argument> arguments);
    template <class Write>
    void answer(Write write);
    void hold(Text rest);
    bool run_urgent(Text& rest, Path& path);
    void tell_dropped(std::size_t count);
    void end_message();

    Shared shared_;
    std::string name_;
    StatusModel status_;
    Format format_;
    Framer framer_{input_limit};
    Path path_;
    std::string response_;  // of the message being executed
    std::string output_;
    std::size_t sent_ = 0;
    bool opc_ = false;
    std::optional<Pause> pause_;
    std::string remainder_;  // of the message that waits
    std::deque<std::string> withheld_;
    std::size_t withheld_bytes_ = 0;
};

}  // namespace shaker::scpi
