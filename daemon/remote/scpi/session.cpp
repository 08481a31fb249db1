#include "daemon/remote/scpi/session.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "daemon/remote/scpi/foreign.hpp"
#include "drivers/errors.hpp"

namespace shaker::scpi {

namespace {

constexpr std::size_t cost_of_a_message = 64;  // bytes, in addition to its text
constexpr std::size_t piece = 4096;            // bytes, after which the start of a message is looked at

bool has_bounds(const Found& found) {
    const Command& command = *found.command;
    return found.query && command.query_parameters.empty() && command.parameters.size() == 1 &&
           command.parameters.front().numeric();
}

}  // namespace

Session::Session(Shared shared, std::string name, Admission admission)
    : shared_{shared}, name_{std::move(name)}, admission_{admission}, status_{shared.status} {}

Session::~Session() { shared_.lock.release(name_); }

void Session::feed(std::string_view bytes) {
    bytes = greeting_.rest(bytes);
    if (!begun_ && !bytes.empty()) {
        begun_ = true;
        if (is_binary(bytes.front())) end("it began like a binary protocol");
    }
    for (; !bytes.empty() && ended_.empty(); bytes.remove_prefix(std::min(piece, bytes.size())))
        if (!take(bytes.substr(0, piece))) end("it spoke HTTP");
}

/// Takes all bytes, or those before a line of HTTP: then false.
bool Session::take(std::string_view bytes) {
    for (;;) {
        switch (framer_.take(bytes)) {
            case Framer::Event::none:
                return !begins_like_http(framer_.begun());
            case Framer::Event::too_long:
                report(Code::input_overrun, std::string{"message of more than "}
                                                .append(std::to_string(input_limit))
                                                .append(" bytes"));
                break;
            case Framer::Event::message: {
                const Text message = framer_.message();
                if (is_http_line({message.at, message.size()})) return false;
                accept(message);
                if (!ended_.empty()) return true;
                break;
            }
        }
    }
}

void Session::end(std::string_view why) {
    ended_ = why;
    pause_.reset();
    owed_.clear();
    remainder_.clear();
    withheld_.clear();
}

void Session::accept(Text message) {
    poll();
    message.skip_blanks();
    if (message.empty()) return;
    ++messages_;
    if (!waiting()) {
        trips_ = shared_.status.trips;
        return run_message(message);
    }
    Path path;
    bool urgent = false;
    while (run_urgent(message, path)) urgent = true;
    if (urgent) drop_withheld();
    message.skip_blanks();
    if (message.empty()) return;
    if (withheld_bytes_ + message.size() + cost_of_a_message > input_limit)
        return report(Code::input_overrun,
                      "more than " + std::to_string(input_limit) + " bytes received during a wait");
    withheld_bytes_ += message.size() + cost_of_a_message;
    withheld_.push_back({{message.at, message.end}, shared_.status.trips});
}

void Session::poll() {
    watch_abort();
    if (opc_ && !shared_.instrument.pending()) {
        opc_ = false;
        status_.raise_event(esr::operation_complete);
    }
    while (waiting() && pause_->over()) {
        const auto reply = std::exchange(pause_, {})->reply;
        try {
            if (reply) answer(reply);
        } catch (const Error& error) {
            report(error.code, error.what());
            if (asked_ != nullptr) answer_without(*asked_, error.code);
        }
        std::string rest = std::exchange(remainder_, {});
        run_units({rest.data(), rest.data() + rest.size()});
        if (!waiting()) end_message();
        if (!waiting() && !owed_.empty()) {
            pause_for(std::move(owed_.front()));
            owed_.pop_front();
        }
        while (!waiting() && !withheld_.empty()) {
            Withheld next = std::move(withheld_.front());
            withheld_.pop_front();
            withheld_bytes_ -= next.message.size() + cost_of_a_message;
            trips_ = next.trips;
            run_message({next.message.data(), next.message.data() + next.message.size()});
        }
    }
}

void Session::finish() {
    if (!ended_.empty()) return;
    if (framer_.begun().find('?') != std::string_view::npos)
        report(Code::query_unterminated, printable(framer_.begun()));
    framer_ = Framer{input_limit};
}

void Session::run_message(Text message) {
    path_ = {};
    response_.clear();
    run_units(message);
    if (!waiting()) end_message();
}

void Session::run_units(Text rest) {
    for (bool blank = false;; blank = false) {
        for (; !rest.empty() && (is_blank(*rest.at) || *rest.at == ';'); ++rest.at)
            blank = is_blank(*rest.at);
        if (rest.empty()) return;
        if (!run_unit(rest, path_, blank)) {
            while (run_urgent(rest, path_)) {
            }
            return;
        }
        if (!ended_.empty()) return;
        if (waiting()) return hold(rest);
    }
}

/// Moves `rest` to the end of its first unit. False when the rest of the message must be dropped.
bool Session::run_unit(Text& rest, Path& path, bool behind_blank) {
    const char* const from = rest.at;
    const Command* asked = nullptr;
    try {
        const Found found = shared_.tree.find(rest, path);
        if (found.query) asked = found.command;
        require_admission(*found.command);
        run_values(found, rest);
        return true;
    } catch (const Error& error) {
        report(error.code, error.what());
        if (asked != nullptr) answer_without(*asked, error.code);
        if (rest.at != from) behind_blank = is_blank(rest.at[-1]) || rest.at[-1] == ',';
        rest.at = first_unit(rest, behind_blank).end;
        return !is_command_error(error.code);
    }
}

void Session::run_values(const Found& found, Text& rest) {
    std::string_view gap = " ";  // "FREQuency 500 HZ, allowed ..."
    const auto about = [&](const std::exception& error) { return found.name().append(gap) + error.what(); };
    try {
        Bound bound{};
        if (has_bounds(found) && read_bound(rest, bound)) {
            const double value = value_of(found.command->parameters.front(), bound);
            return answer([&](Reply& reply) { reply.number(value); });
        }
        const auto& parameters = found.query ? found.command->query_parameters : found.command->parameters;
        Arguments arguments;
        const std::span<const Argument> values = read_arguments(rest, parameters, arguments);
        gap = ": ";
        execute(found, values);
    } catch (const Error& error) {
        throw Error{error.code, about(error)};
    } catch (const InputError& error) {
        throw Error{Code::parameter, about(error)};
    } catch (const DeviceError& error) {
        throw Error{Code::hardware, about(error)};
    } catch (const TripError& error) {
        throw Error{Code::abort, error.what()};
    } catch (const std::exception& error) {
        throw Error{Code::system, about(error)};
    }
}

void Session::execute(const Found& found, std::span<const Argument> arguments) {
    const std::span suffixes = std::span{found.suffixes}.first(found.suffix_count);
    const Command& command = *found.command;
    if (found.query) {
        if (!waiting()) asked_ = &command;  // else it is ABORt?, and the query that waits stays the asked one
        return answer([&](Reply& reply) {
            Call call{*this, arguments, suffixes, reply};
            command.query(call);
        });
    }
    if (command.guarded) require_control();
    std::string none;
    Reply silent{none, format_, 0};
    Call call{*this, arguments, suffixes, silent};
    command.set(call);
}

/// A query that fails leaves no part of its answer.
template <class Write>
void Session::answer(Write write) {
    const std::size_t before = response_.size();
    if (before > 0) response_ += ';';
    Reply reply{response_, format_, output_limit};
    try {
        write(reply);
        if (reply.overflown())
            throw Error{Code::query_deadlocked,
                        "more than " + std::to_string(output_limit) + " bytes in the replies to one message"};
        if (reply.empty() && !waiting()) throw Error{Code::system, "no reply was written"};
    } catch (...) {
        response_.resize(before);
        throw;
    }
    if (reply.empty()) response_.resize(before);  // *OPC? answers later
}

/// The client sent a valid query and reads its answer, so it gets one for any error. No answer to a message
/// that was not understood (IEEE 488.2), or when the output is full.
void Session::answer_without(const Command& command, Code code) {
    if (is_command_error(code) || is_query_error(code) || admission_ == Admission::abort_only) return;
    try {
        answer([&](Reply& reply) { command.without(reply); });
    } catch (const Error& error) {
        report(error.code, error.what());
    }
}

/// Keeps the rest of a paused message; `path_` keeps its position.
void Session::hold(Text rest) {
    while (run_urgent(rest, path_)) {
    }
    remainder_.assign(rest.at, rest.end);
}

/// Runs the next urgent unit in `rest` and moves past it. Without an urgent unit: false, `rest` unchanged.
/// Units that cannot be parsed yet are skipped.
bool Session::run_urgent(Text& rest, Path& path) {
    Text look = rest;
    Path there = path;
    std::size_t passed = 0;
    while (!look.empty()) {
        Text unit = first_unit(look, false);
        look.at = unit.end + (unit.end != look.end ? 1 : 0);
        unit.skip_blanks();
        if (unit.empty()) continue;
        const Text begin = unit;
        const Path before = there;
        try {
            const Found found = shared_.tree.find(unit, there);
            if (found.command->urgent) {
                unit = begin;
                path = before;
                run_unit(unit, path, false);
                rest = look;
                if (passed > 0) report_dropped(passed);
                return true;
            }
        } catch (const Error&) {
            there = before;
        }
        ++passed;
    }
    return false;
}

void Session::drop_withheld() {
    const std::size_t lost = withheld_.size() + (remainder_.empty() ? 0 : 1);
    remainder_.clear();
    withheld_.clear();
    withheld_bytes_ = 0;
    if (lost > 0) report_dropped(lost);
}

void Session::report_dropped(std::size_t count) {
    report(Code::execution, std::to_string(count) + " messages before ABORt were dropped");
}

void Session::end_message() {
    if (response_.empty()) return;
    if (output().size() + response_.size() + 1 > output_limit)
        report(Code::query_interrupted, "a message came before the replies to earlier ones were read");
    else
        (output_ += response_) += '\n';
    response_.clear();
}

std::string_view Session::output() const noexcept { return std::string_view{output_}.substr(sent_); }

void Session::sent(std::size_t bytes) {
    sent_ += std::min(bytes, output_.size() - sent_);
    if (2 * sent_ < output_.size()) return;
    output_.erase(0, sent_);
    sent_ = 0;
}

std::uint8_t Session::status_byte() noexcept {
    return status_.status_byte(!response_.empty() || !output().empty());
}

void Session::complete_operation() {
    opc_ = shared_.instrument.pending();
    if (!opc_) status_.raise_event(esr::operation_complete);
}

void Session::require_admission(const Command& command) const {
    if (command.open || unlocked()) {
        if (admission_ != Admission::abort_only || command.urgent) return;
        throw Error{Code::command_protected, "no session is free; only ABORt is obeyed"};
    }
    throw Error{Code::command_protected, "send SYSTem:PASSword with the daemon's token first"};
}

bool Session::unlocked() const noexcept {
    const std::string& token = shared_.access.token;
    return admission_ != Admission::password || token.empty() || password_ == token;
}

void Session::unlock(std::string_view password) {
    if (shared_.access.token_allowed(password)) {
        password_ = shared_.access.token;
        wrong_passwords_ = 0;
        return;
    }
    if (++wrong_passwords_ == most_wrong_passwords) end("it sent wrong passwords");
    throw Error{Code::settings_conflict, "wrong password"};
}

void Session::abort() { unanswered_ = shared_.instrument.abort(*this); }

void Session::abort_and_answer() {
    access::Aborts::Receipt receipt = shared_.instrument.abort(*this);
    if (!waiting()) return pause_for(std::move(receipt));
    if (owed_.size() == most_owed)
        throw Error{Code::query_deadlocked, "too many answers of ABORt? during a wait; it was obeyed"};
    owed_.push_back(std::move(receipt));
}

void Session::watch_abort() {
    if (!unanswered_) return;
    const access::Aborts::Answer answer = unanswered_();
    if (answer == access::Aborts::Answer::none) return;
    unanswered_ = nullptr;
    hear(answer);
}

void Session::pause_for(access::Aborts::Receipt receipt) {
    using Answer = access::Aborts::Answer;
    const auto answer = std::make_shared<Answer>(Answer::none);
    pause({[answer, receipt = std::move(receipt)] { return (*answer = receipt()) != Answer::none; },
           [this, answer](Reply& reply) {
               reply.boolean(*answer == Answer::obeyed);
               hear(*answer);
           }});
}

void Session::hear(access::Aborts::Answer answer) {
    abort_failed_ = answer == access::Aborts::Answer::silent;
    if (abort_failed_) report(Code::output_silent, access::Aborts::silent_text);
}

void Session::require_control() const {
    if (!shared_.lock.allows(name_))
        throw Error{Code::command_protected, access::held_text(printable(shared_.lock.owner()))};
}

}  // namespace shaker::scpi
