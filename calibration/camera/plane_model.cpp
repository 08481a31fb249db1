#include "calibration/camera/plane_model.hpp"

#include <algorithm>
#include <cmath>

namespace shaker::calibration {

namespace {

constexpr int board_unknown = PlaneModel::camera_unknowns, first_level = board_unknown + 1;

// Origin, angle and scale of the board among points (similarity by least squares).
struct Similarity {
    double a = 0, b = 0, turn = 0, scale = 1;
};

Similarity similarity(const std::vector<optics::Point>& from, const std::vector<optics::Point>& to) {
    const auto n = static_cast<double>(from.size());
    optics::Point f{}, t{};
    for (std::size_t i = 0; i < from.size(); ++i)
        for (std::size_t k = 0; k < 2; ++k) f[k] += from[i][k] / n, t[k] += to[i][k] / n;
    double cosine = 0, sine = 0, squares = 0;
    for (std::size_t i = 0; i < from.size(); ++i) {
        const double fx = from[i][0] - f[0], fy = from[i][1] - f[1], tx = to[i][0] - t[0],
                     ty = to[i][1] - t[1];
        cosine += fx * tx + fy * ty;
        sine += fx * ty - fy * tx;
        squares += fx * fx + fy * fy;
    }
    Similarity s{.turn = std::atan2(sine, cosine), .scale = std::hypot(sine, cosine) / squares};
    s.a = t[0] - s.scale * (std::cos(s.turn) * f[0] - std::sin(s.turn) * f[1]);
    s.b = t[1] - s.scale * (std::sin(s.turn) * f[0] + std::cos(s.turn) * f[1]);
    return s;
}

}  // namespace

PlaneModel::PlaneModel(std::span<const PlacedBoard> pictures, const optics::Board& board,
                       const BoardKnowledge& known)
    : pictures_{pictures}, board_{board}, known_{known} {
    for (std::size_t k = 0; k < pictures.size(); ++k) {
        if (std::ranges::find(levels_, pictures[k].offset_mm) == levels_.end())
            levels_.push_back(pictures[k].offset_mm);
        for (const SeenCorner& corner : pictures[k].seen.corners) observations.push_back({k, corner});
    }
    begin();
}

int PlaneModel::level_of(std::size_t picture) const {
    return first_level +
           static_cast<int>(std::ranges::find(levels_, pictures_[picture].offset_mm) - levels_.begin());
}

int PlaneModel::first_of_pose(std::size_t picture) const {
    return first_level + static_cast<int>(levels_.size() + 3 * picture);
}

// The first view has no lens and a scale of 1 mm/px; each board then shows its scale.
void PlaneModel::begin() {
    const double width = pictures_.front().seen.width, height = pictures_.front().seen.height;
    start_ = Eigen::VectorXd::Zero(first_of_pose(pictures_.size()));
    View view;
    view.mm_per_px = 1;
    view.along = known_.settings.along;
    view.lens = {.centre_px = {0.5 * (width - 1), 0.5 * (height - 1)}, .focal_px = width};
    std::vector<Similarity> found;
    double scales = 0, all = 0;
    for (std::size_t k = 0; k < pictures_.size(); ++k) {
        std::vector<optics::Point> from, to;
        for (const SeenCorner& c : pictures_[k].seen.corners) {
            from.push_back(board_.corner(c.number));
            to.push_back(optics::place_at(view, 0, c.at_px));
        }
        found.push_back(similarity(from, to));
        const double count = static_cast<double>(from.size());
        const double shrink =
            telecentric() ? 1
                          : 1 - pictures_[k].offset_mm / known_.settings.distance_mm;  // of the plane's scale
        scales += count / found.back().scale / shrink;
        all += count;
    }
    const double scale = scales / all, distance = telecentric() ? 0 : known_.settings.distance_mm;
    start_[0] = std::log(scale);
    start_[1] = telecentric() ? 0 : std::log(distance);
    start_[4] = view.lens.centre_px[0];
    start_[5] = view.lens.centre_px[1];
    for (std::size_t k = 0; k < found.size(); ++k) {
        const int at = first_of_pose(k);
        start_[at] = found[k].a * scale;
        start_[at + 1] = found[k].b * scale;
        start_[at + 2] = found[k].turn;
    }
    const double corner = 0.25 * (width * width + height * height) / (width * width);  // r^2 at a corner
    constexpr double distortion = 0.1, second_distortion = 0.02;  // at a corner, relative
    priors_ = {{1, start_[1], known_.distance_error},         {4, start_[4], known_.centre_share * width},
               {5, start_[5], known_.centre_share * width},   {6, 0, distortion / corner},
               {7, 0, second_distortion / (corner * corner)}, {board_unknown, 0, known_.board_error}};
    for (std::size_t k = 0; k < levels_.size(); ++k)
        priors_.push_back({first_level + static_cast<int>(k), 0, known_.offset_error_mm});
}

// The unit of the lens's radii is the picture's width.
View PlaneModel::view_of(const Eigen::VectorXd& x) const {
    View view;
    view.along = known_.settings.along;
    view.mm_per_px = std::exp(x[0]);
    view.distance_mm = telecentric() ? 0 : std::exp(x[1]);
    view.tilt_deg = {x[2], x[3]};
    view.lens = {.centre_px = {x[4], x[5]},
                 .focal_px = static_cast<double>(pictures_.front().seen.width),
                 .k1 = x[6],
                 .k2 = x[7]};
    return view;
}

optics::BoardPose PlaneModel::pose_of(const Eigen::VectorXd& x, std::size_t picture) const {
    const int at = first_of_pose(picture);
    return {{x[at], x[at + 1]}, x[at + 2], pictures_[picture].offset_mm + x[level_of(picture)]};
}

Eigen::Vector2d PlaneModel::residual(const Eigen::VectorXd& x, const Observation& o) const {
    const optics::BoardPose pose = pose_of(x, o.picture);
    const double longer = std::exp(x[board_unknown]);
    const optics::Point c = board_.corner(o.corner.number);
    const optics::Point at =
        optics::image_of(view_of(x), pose.offset_mm, pose.place_of({longer * c[0], longer * c[1]}));
    return {o.corner.at_px[0] - at[0], o.corner.at_px[1] - at[1]};
}

void PlaneModel::correct_bends(const Eigen::VectorXd& x) {
    const View view = view_of(x);
    std::vector<SeenCorner> seen;
    for (const PlacedBoard& p : pictures_)
        seen.insert(seen.end(), p.seen.corners.begin(), p.seen.corners.end());
    for (std::size_t i = 0; i < observations.size(); ++i) {
        const optics::BoardPose pose = pose_of(x, observations[i].picture);
        const optics::Point c = board_.corner(seen[i].number);
        const double far = seen[i].reach_px * view.mm_per_px;
        const auto at = [&](double dx, double dy) {
            const optics::Point p =
                optics::image_of(view, pose.offset_mm, pose.place_of({c[0] + dx, c[1] + dy}));
            return Eigen::Vector2d{p[0], p[1]};
        };
        for (const auto& [dx, dy] : {std::array{far, 0.0}, std::array{0.0, far}}) {
            const Eigen::Vector2d there = at(dx, dy), back = at(-dx, -dy),
                                  along = (there - back).normalized();
            const Eigen::Vector2d sagitta = 0.5 * (there + back) - at(0, 0);
            const Eigen::Vector2d bend = (sagitta - sagitta.dot(along) * along) / 3;  // mean over the edge
            seen[i].at_px[0] -= bend[0];
            seen[i].at_px[1] -= bend[1];
        }
        observations[i].corner = seen[i];
    }
}

PlaneModel::Normal PlaneModel::normal(const Eigen::VectorXd& x, double noise_px) const {
    const auto size = x.size();
    Normal sum{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};
    const double weight = 1 / (noise_px * noise_px);
    std::vector<int> touched(static_cast<std::size_t>(first_level + 4));
    Eigen::MatrixXd slopes(2, first_level + 4);
    Eigen::VectorXd near = x;
    for (const Observation& o : observations) {
        if (!o.used) continue;
        for (int k = 0; k < first_level; ++k) touched[static_cast<std::size_t>(k)] = k;
        touched[static_cast<std::size_t>(first_level)] = level_of(o.picture);
        for (int k = 0; k < 3; ++k)
            touched[static_cast<std::size_t>(first_level + 1 + k)] = first_of_pose(o.picture) + k;
        const Eigen::Vector2d off = residual(x, o);
        for (std::size_t k = 0; k < touched.size(); ++k) {
            constexpr double step = 1e-6;
            const double h = step * std::max(1.0, std::abs(x[touched[k]]));
            near[touched[k]] = x[touched[k]] + h;
            const Eigen::Vector2d up = residual(near, o);
            near[touched[k]] = x[touched[k]] - h;
            slopes.col(static_cast<Eigen::Index>(k)) = (residual(near, o) - up) / (2 * h);  // of the image
            near[touched[k]] = x[touched[k]];
        }
        for (std::size_t i = 0; i < touched.size(); ++i) {
            const auto column = slopes.col(static_cast<Eigen::Index>(i));
            sum.gradient[touched[i]] += weight * column.dot(off);
            for (std::size_t k = 0; k < touched.size(); ++k)
                sum.matrix(touched[i], touched[k]) +=
                    weight * column.dot(slopes.col(static_cast<Eigen::Index>(k)));
        }
        sum.squares_px += off.squaredNorm();
        sum.count += 2;
    }
    sum.cost = weight * sum.squares_px;
    for (const Prior& p : priors_) {
        const double w = 1 / (p.sigma * p.sigma), off = p.mean - x[p.unknown];
        sum.matrix(p.unknown, p.unknown) += w;
        sum.gradient[p.unknown] += w * off;
        sum.cost += w * off * off;
    }
    return sum;
}

double PlaneModel::cost(const Eigen::VectorXd& x, double noise_px) const {
    double squares = 0, priors = 0;
    for (const Observation& o : observations)
        if (o.used) squares += residual(x, o).squaredNorm();
    for (const Prior& p : priors_) priors += std::pow((p.mean - x[p.unknown]) / p.sigma, 2);
    return squares / (noise_px * noise_px) + priors;
}

}  // namespace shaker::calibration
