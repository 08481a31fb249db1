#include "drivers/walker/changing_walker.hpp"

#include <cmath>
#include <stdexcept>

namespace shaker::walker {

ChangingWalker::ChangingWalker(const WalkerSetting& setting, double v)
    : setting_{checked(setting)}, history_{setting.friction.change, 1 / setting.frequency}, now_{.v = v} {
    if (!setting.friction.closed_form()) integrated_.emplace(setting, v);
}

WalkerLaw ChangingWalker::law_with(double mu_factor) const {
    WalkerSetting s = setting_;
    s.friction.mu_k *= mu_factor;
    s.friction.mu_s *= mu_factor;
    return WalkerLaw{s};
}

double ChangingWalker::advance_period() {
    const double before = mu_factor_;
    mu_factor_ = history_.next();
    ++period_;
    if (integrated_) {
        integrated_->set_mu_factor(mu_factor_);
        const double walked = integrated_->advance_period();
        now_ = integrated_->now();
        return walked;
    }
    if (!law_ || mu_factor_ != before) law_.emplace(law_with(mu_factor_));
    Walker walker{*law_, now_.v};
    const double walked = walker.advance_period();
    now_ = {now_.x + walked, walker.now().v, walker.now().contact};
    return walked;
}

MeanWalk mean_walk(const WalkerSetting& setting, double v_start, int skipped, int periods) {
    constexpr int batches = 16;
    if (skipped < 0 || periods < batches) throw std::invalid_argument{"mean_walk: at least 16 periods"};
    ChangingWalker walker{setting, v_start};
    for (int k = 0; k < skipped; ++k) walker.advance_period();
    const int each = periods / batches;
    MeanWalk mean{.mu_factor = 0};
    double squares = 0;
    for (int b = 1; b <= batches; ++b) {
        double walked = 0;
        for (int k = 0; k < each; ++k) {
            walked += walker.advance_period();
            mean.mu_factor += walker.mu_factor() / (batches * each);
        }
        const double v_D = walked * setting.frequency / each, off = v_D - mean.v_D;
        mean.v_D += off / b;
        squares += off * (v_D - mean.v_D);
    }
    mean.v_D_error = std::sqrt(squares / (batches - 1) / batches);
    return mean;
}

}  // namespace shaker::walker
