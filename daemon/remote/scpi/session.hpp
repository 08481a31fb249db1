#pragma once
// Session: one client. Bytes in, bytes out, status and errors. No sockets, threads or clock.
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/remote/access/access.hpp"
#include "daemon/remote/scpi/command.hpp"
#include "daemon/remote/scpi/command_tree.hpp"
#include "daemon/remote/scpi/framer.hpp"
#include "daemon/remote/scpi/reply.hpp"
#include "daemon/remote/scpi/status_model.hpp"

namespace shaker::scpi {

class Session;

/// What the common commands require of the bench. Called from the thread that runs the sessions; no function
/// waits.
class Instrument {
public:
    virtual ~Instrument() = default;
    /// "maker,model,serial,firmware".
    [[nodiscard]] virtual std::string identity() const = 0;
    /// Names separated by commas; "0" for none.
    [[nodiscard]] virtual std::string options() const = 0;
    /// Ramps the drive to zero and ends sequences; calibration is kept.
    virtual void reset(const Session& by) = 0;
    /// 0: no error.
    virtual int self_test() = 0;
    virtual void trigger(const Session& by) = 0;
    /// Settings in place 0 to 9.
    virtual void save(int place) = 0;
    virtual void recall(const Session& by, int place) = 0;
    /// Stops the drive at once and latches the stop. Any session may call it at any time; all others must
    /// then drop their withheld input, see Session::drop_withheld(). The receipt reports whether the output
    /// has obeyed.
    virtual access::Aborts::Receipt abort(const Session& by) = 0;
    /// True while an overlapped command (ramp, identification, sequence) is in progress; used by *OPC, *OPC?
    /// and *WAI.
    [[nodiscard]] virtual bool pending() const = 0;
};

/// Objects shared by all sessions; they must outlive them.
struct Shared {
    const CommandTree& tree;
    Instrument& instrument;
    DeviceStatus& status;
    access::ControlLock& lock;
    const access::Access& access;  // its token is the password
};

/// The door by which a client came.
enum class Admission : std::uint8_t {
    free,        // needs no password
    password,    // needs SYSTem:PASSword if there is a token
    abort_only,  // only ABORt is obeyed
};

/// Messages and replies end with LF. An error in parsing (-1xx) drops the rest of the message; any other
/// error ends its unit only. After *WAI and *OPC? input is withheld until the instrument is done; an urgent
/// command (ABORt) in it runs at once and drops all input withheld before it. A client that speaks another
/// protocol, and one that tries passwords, is not obeyed any more: see ended().
class Session {
public:
    static constexpr std::size_t input_limit = 65536;      // bytes of one message, and of withheld input
    static constexpr std::size_t output_limit = 1U << 20;  // bytes of unsent replies
    static constexpr int most_wrong_passwords = 3;
    static constexpr std::size_t most_owed = 64;  // answers of ABORt? during a wait

    /// name: the client's address, shown to other clients as the holder of control.
    Session(Shared shared, std::string name, Admission admission = Admission::free);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// Received bytes, in pieces of any size.
    void feed(std::string_view bytes);
    /// Continues withheld input when the instrument is done. Call often.
    void poll();
    /// Call when the client sends no more. An incomplete message is not executed; if it contains a query,
    /// error -420.
    void finish();
    [[nodiscard]] bool waiting() const noexcept { return pause_.has_value(); }
    /// The reason why the connection must be closed; empty: it may stay open.
    [[nodiscard]] std::string_view ended() const noexcept { return ended_; }
    /// True until the output has answered the newest ABORt, or did not in time.
    [[nodiscard]] bool aborting() const noexcept { return unanswered_ || waiting(); }
    /// The output did not answer the newest ABORt in time.
    [[nodiscard]] bool abort_failed() const noexcept { return abort_failed_; }
    /// Number of messages so far that were not blank.
    [[nodiscard]] std::uint64_t messages() const noexcept { return messages_; }

    /// Replies to send. Call sent() with the number of bytes sent.
    [[nodiscard]] std::string_view output() const noexcept;
    void sent(std::size_t bytes);

    /// An error of the device, or a trip; reported to all sessions.
    void report(Code code, std::string_view detail) { status_.report(code, detail); }
    [[nodiscard]] std::uint64_t reported() const noexcept { return status_.reported(); }
    /// Call after ABORt of another session: drops the withheld input, and reports it by error -200.
    void drop_withheld();

    // For handlers.
    /// Trips of the bench that had been shown when the present message was received.
    [[nodiscard]] std::uint64_t trips() const noexcept { return trips_; }
    [[nodiscard]] const Shared& shared() const noexcept { return shared_; }
    [[nodiscard]] StatusModel& status() noexcept { return status_; }
    [[nodiscard]] Format& format() noexcept { return format_; }
    [[nodiscard]] const std::string& name() const noexcept { return name_; }
    [[nodiscard]] std::uint8_t status_byte() noexcept;
    void complete_operation();                          // *OPC
    void forget_operation() noexcept { opc_ = false; }  // *CLS, *RST
    /// For *WAI, *OPC?, READ?: withholds further input until `over`, called by poll(), is true. Then `reply`,
    /// if any, writes the answer or throws as a query may.
    struct Pause {
        std::function<bool()> over;
        std::function<void(Reply&)> reply;
    };
    void pause(Pause pause) { pause_ = std::move(pause); }
    /// Throws Error -203 unless this session may change the bench.
    void require_control() const;
    /// ABORt; error 113 follows if the output does not obey.
    void abort();
    /// ABORt?: the answer, 1 or 0, follows when the output has obeyed or did not in time.
    void abort_and_answer();
    /// SYSTem:PASSword. Error -221 for a wrong one; most_wrong_passwords end the session.
    void unlock(std::string_view password);
    void lock_again() noexcept { password_.clear(); }
    [[nodiscard]] bool unlocked() const noexcept;

private:
    void end(std::string_view why);
    bool take(std::string_view bytes);
    void accept(Text message);
    void require_admission(const Command& command) const;
    void watch_abort();
    void pause_for(access::Aborts::Receipt receipt);
    void hear(access::Aborts::Answer answer);
    void run_message(Text message);
    void run_units(Text rest);
    bool run_unit(Text& rest, Path& path, bool behind_blank);
    void run_values(const Found& found, Text& rest);
    void execute(const Found& found, std::span<const Argument> arguments);
    template <class Write>
    void answer(Write write);
    void answer_without(const Command& command, Code code);
    void hold(Text rest);
    bool run_urgent(Text& rest, Path& path);
    void report_dropped(std::size_t count);
    void end_message();

    Shared shared_;
    std::string name_;
    Admission admission_;
    std::string password_;  // the newest right one
    int wrong_passwords_ = 0;
    std::string_view ended_;
    bool begun_ = false;  // a byte was received
    std::uint64_t trips_ = 0;
    std::uint64_t messages_ = 0;
    bool abort_failed_ = false;
    access::Aborts::Receipt unanswered_;          // of the newest ABORt
    std::deque<access::Aborts::Receipt> owed_{};  // of ABORt? during a wait
    StatusModel status_;
    Format format_;
    TelnetGreeting greeting_;
    Framer framer_{input_limit};
    Path path_;
    std::string response_;  // of the message being executed
    std::string output_;
    std::size_t sent_ = 0;
    bool opc_ = false;
    std::optional<Pause> pause_;
    const Command* asked_ = nullptr;  // the newest query, or the one that has paused
    std::string remainder_;           // of the paused message
    struct Withheld {
        std::string message;
        std::uint64_t trips;  // shown when it was received
    };
    std::deque<Withheld> withheld_;
    std::size_t withheld_bytes_ = 0;
};

}  // namespace shaker::scpi
