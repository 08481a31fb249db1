#include "tests/orders/clients.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <utility>

namespace shaker::orders {

namespace {

using nlohmann::json;

constexpr std::array nonsense{"OUTP PERHAPS\n",
                              "ACC 1e9\n",
                              "*RST\n",
                              "FETC:DRIF?\n",
                              "SYST:LOCK:REQ?\n",
                              "SYST:LOCK:REL\n",
                              "GET / HTTP/1.1\r\nHost: bench\r\n\r\n",
                              "\x1b]0;owned\x07\n",
                              "*WAI\n",
                              "AVER:PER 5;SETT 4\n"};

const char* nonsense_for(double value) {
    return nonsense.at(static_cast<std::size_t>(value * nonsense.size()));
}

Drive drive_for(double value, double frequency) {
    Drive d;
    d.frequency = frequency;
    d.gamma = gamma_for(value, frequency);
    d.phi = 2 * std::numbers::pi * std::fmod(7 * value, 1.0);
    return d;
}

}  // namespace

Clients::Clients(service::BenchPort& port, Laws& laws)
    : port_{port},
      laws_{laws},
      pending_orders_{port, [this](std::function<void()> f) { later_.push_back(std::move(f)); }},
      aborts_{{.stop = [&port](const std::string& by) { return port.abort(by); },
               .obeyed = [&port] { return port.obeyed(); }}},
      instrument_{pending_orders_, aborts_,
                  [this](const std::string& session, const std::string& why) {
                      for (const auto& s : sessions_)
                          if (s && s->name() == session) s->report(scpi::Code::settings_conflict, why);
                  }},
      tree_{command_table(instrument_)},
      actions_{pending_orders_, lock_, aborts_} {
    aborts_.after([this](const std::string& by) {
        instrument_.armed = false;
        for (std::size_t i = 0; i < sessions_.size(); ++i) {
            if (!sessions_.at(i) || sessions_[i]->name() == by) continue;
            take_answers(i);
            sessions_[i]->drop_withheld();
            answers_.at(i).dropped();
        }
    });
    for (std::size_t i = 0; i < sessions_.size(); ++i) open(i);
}

Clients::~Clients() = default;

void Clients::open(std::size_t session) {
    if (sessions_.at(session)) {
        sessions_[session]->finish();
        lock_.release(sessions_[session]->name());
    }
    answers_.at(session).forget();
    sessions_[session] =
        std::make_unique<scpi::Session>(scpi::Shared{tree_, instrument_, status_, lock_, access_},
                                        fmt::format("client {}.{}", session, ++opened_.at(session)));
}

void Clients::send(std::size_t session, const std::string& text) {
    scpi::Session& to = *sessions_.at(session);
    to.poll();
    take_answers(session);
    const bool urgent = text.starts_with("ABOR");
    if (urgent && to.waiting()) answers_.at(session).dropped();
    if (const std::string form = form_of(text); !form.empty())
        answers_.at(session).asked(form, to.waiting() && !urgent);
    to.feed(text);
}

// Each query is answered once, at once unless the session waits.
void Clients::take_answers(std::size_t session) {
    constexpr const char* law = "answers of SCPI";
    scpi::Session& from = *sessions_.at(session);
    ScpiAnswers& answers = answers_.at(session);
    std::istringstream lines{std::string{from.output()}};
    from.sent(from.output().size());
    for (std::string line; std::getline(lines, line);)
        if (const std::string wrong = answers.take(line); !wrong.empty()) laws_.broken(law, wrong);
    if (from.waiting() || !from.ended().empty()) return;
    answers.nothing_withheld();
    if (const std::string due = answers.due(); !due.empty()) {
        laws_.broken(law, "no answer of the form " + due);
        answers.forget();
    }
}

void Clients::reload(double value) {
    const auto now = port_.state();
    if (!now) return;
    safety::Limits limits = now->limits;
    limits.drive.abort *= 0.5 + value;
    limits.drive.warn = 0.8 * limits.drive.abort;
    laws_.limit_named(limits.drive.abort);
    port_.order({service::Adopt{now->wanted, now->plan, limits}, {}});
}

void Clients::act(const Move& move) {
    const auto now = port_.state();
    if (move.action == Action::abort) laws_.aborted();
    if (move.action == Action::reload) return reload(move.value);
    say(move.client, move.action, move.value);
}

void Clients::post(const std::string& name, const std::string& body, Action action) {
    requests_.push_back({name, laws_.now_s()});
    const auto request = std::prev(requests_.end());
    const std::string remark = action == Action::remark ? json::parse(body)["text"].get<std::string>() : "";
    actions_.act(name, body, "page", [this, request, remark, action](const web::Answer& answer) {
        if (answer.status == 200 && !remark.empty()) remarks_.emplace_back(laws_.now_s(), remark);
        if (answer.status == 200 && action == Action::stop) laws_.ended();
        requests_.erase(request);
    });
}

void Clients::say(int client, Action action, double value) {
    const auto now = port_.state();
    const bool http = client == 2;
    const double frequency = now ? now->wanted.frequency : 20;
    const Drive drive = drive_for(value, value > 0.9 ? frequency * 0.8 : frequency);
    const double limit_V = now ? now->limits.drive.abort * (0.3 + 0.7 * value) : 1;
    const double limit_a = now ? now->limits.acceleration.abort * (0.3 + 0.7 * value) : 1;
    const auto order = [&](const char* name, const json& body, const std::string& scpi) {
        if (http)
            post(name, body.is_null() ? std::string{} : body.dump(), action);
        else
            send(static_cast<std::size_t>(client), scpi + "\n");
    };
    switch (action) {
        case Action::drive:
            return order(
                "drive",
                {{"frequency_hz", drive.frequency}, {"gamma_mps2", drive.gamma}, {"phi_rad", drive.phi}},
                fmt::format("APPL:BIH {}, {}, 0.5, {}", drive.frequency, drive.gamma, drive.phi));
        case Action::start:
            return order("start",
                         {{"periods", 3 + static_cast<int>(8 * value)},
                          {"settle_periods", 3},
                          {"measurements", value > 0.8 ? 1 : 0}},
                         value > 0.8 ? "TRIG:COUN 1;:OUTP ON" : "TRIG:COUN INF;:OUTP ON");
        case Action::identify:
            return order("identify", nullptr, "CONT:IDEN");
        case Action::stop:
            return order("stop", nullptr, "OUTP OFF");
        case Action::abort:
            return order("abort", nullptr, value < 0.5 ? "ABOR" : "ABOR?");
        case Action::clear:
            return order("clear", nullptr, "OUTP:PROT:CLE");
        case Action::remark: {
            const std::string words = fmt::format("remark {}", ++remarked_);
            return order("remark", {{"text", words}}, "REC:NOTE '" + words + "'");
        }
        case Action::record: {
            const std::string name = fmt::format("recording-{}", ++recorded_);
            return order("record", {{"on", true}, {"name", name}}, "REC ON,'" + name + "'");
        }
        case Action::unrecord:
            return order("record", {{"on", false}}, "REC OFF");
        case Action::loop:
            return order("loop", {{"closed", value < 0.5}}, value < 0.5 ? "CONT:LOOP 1" : "CONT:LOOP 0");
        case Action::middle:
            return order("middle", nullptr, "OUTP:MIDD");
        case Action::mu: {
            const double mu = 0.02 * std::pow(100.0, value);
            return order("mu", {{"mu", mu}, {"sigma", 0.1 * mu}},
                         fmt::format("WALK:MU {}, {}", mu, 0.1 * mu));
        }
        case Action::lower_drive:
            laws_.limit_named(limit_V);
            return send(0, fmt::format("{} {}\n", value < 0.5 ? "LIM:DRIV:ABOR" : "OUTP:PROT:LEV", limit_V));
        case Action::lower_motion:
            laws_.limit_named(limit_a);
            return send(1, fmt::format("LIM:ACC:ABOR {}\n", limit_a));
        case Action::read:
            return send(static_cast<std::size_t>(client % 2), "READ?\n");
        case Action::ask: {
            const auto& queries = plain_queries();
            const auto which = static_cast<std::size_t>(value * static_cast<double>(queries.size()));
            return send(static_cast<std::size_t>(client % 2),
                        queries.at(std::min(which, queries.size() - 1)).text + "\n");
        }
        case Action::disconnect:
            send(static_cast<std::size_t>(client % 2), "OUTP ON;:ACC ");
            return open(static_cast<std::size_t>(client % 2));
        case Action::nonsense:
            if (http) return post("nonsense", "{\"a\":", action);
            return send(static_cast<std::size_t>(client), nonsense_for(value));
        case Action::campaign:
            return post("campaign",
                        json{{"scan", "phi"}, {"from", 0}, {"to", 2}, {"steps", 3}, {"periods", 5}}.dump(),
                        action);
        case Action::word: {
            const auto which = static_cast<std::size_t>(value * campaign::word_names.size());
            const std::string word{campaign::word_names.at(which)};
            return order(("campaign/" + word).c_str(), nullptr, "CAMP:" + word);
        }
        case Action::reload:
        case Action::recover:
        case Action::same_name:
            return;
    }
}

// The log has a row "clear by NAME (N more within ...)" for accepted clears.
void Clients::see_clears() {
    std::uint64_t accepted = 0;
    for (const service::BenchEvent& e : port_.events(0)) {
        if (e.kind != "order" || !e.text.starts_with("clear by ")) continue;
        const auto more = e.text.find(" (");
        accepted += 1 + (more == std::string::npos ? 0 : std::stoull(e.text.substr(more + 2)));
    }
    if (std::exchange(clears_, accepted) != accepted) laws_.cleared();
}

void Clients::turn() {
    for (std::size_t n = later_.size(); n > 0; --n) {
        const auto next = std::move(later_.front());
        later_.pop_front();
        next();
    }
    if (const auto now = port_.state()) {
        if (now->state == run::RunState::tripped) see_clears();
        instrument::show(*now, status_);
    }
    actions_.update();
    for (std::size_t i = 0; i < sessions_.size(); ++i) {
        sessions_[i]->poll();
        take_answers(i);
        if (!sessions_[i]->ended().empty()) open(i);
    }
}

void Clients::require_answers(double most_s) {
    for (const Request& r : requests_)
        if (laws_.now_s() - r.since_s > most_s) laws_.unanswered(r.what, r.since_s);
}

}  // namespace shaker::orders
