// One round of FCL's dynamic AABB tree on a polyline: new boxes, refit, list of overlapping pairs that are not neighbours along the line.
//
//     g++ -O3 -march=native -I/usr/include/eigen3 fcl_round.cpp -lfcl -lccd -o fcl_round
//     ./fcl_round points.f64 neighbours repeat            # x y z of each point as f64, little endian
//
// FCL's tree (fcl::detail::HierarchyTree) is used directly, with leaves in an array and a double recursion, which is the least it can cost: its manager
// (DynamicAABBTreeCollisionManager) adds a hash table of objects, callbacks and a rebalancing after each refit, and took far longer on these inputs.
// The tree is built once outside the time, like ours. Prints medians of the process's CPU time and the number of pairs.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <utility>
#include <vector>

#include <fcl/broadphase/detail/hierarchy_tree.h>
#include <fcl/math/bv/AABB.h>

namespace {

using Scalar = double;
using Box = fcl::AABB<Scalar>;
using Point = fcl::Vector3<Scalar>;
using Node = fcl::detail::NodeBase<Box>;
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

constexpr Scalar kRadius = 1.0;

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

template <typename F>
double median_seconds(int repeat, F&& run) {
  std::vector<double> times;
  for (int k = 0; k < repeat; ++k) {
    const double before = cpu_seconds();
    run();
    times.push_back(cpu_seconds() - before);
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

std::vector<Point> read_points(const char* name) {
  std::ifstream file(name, std::ios::binary | std::ios::ate);
  std::vector<double> numbers(static_cast<std::size_t>(file.tellg()) / sizeof(double));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(numbers.data()), static_cast<std::streamsize>(numbers.size() * sizeof(double)));
  std::vector<Point> points;
  for (std::size_t k = 0; k + 2 < numbers.size(); k += 3) points.emplace_back(numbers[k], numbers[k + 1], numbers[k + 2]);
  return points;
}

Box box_of(const std::vector<Point>& points, std::size_t i) {
  Box box;
  box.min_ = points[i].cwiseMin(points[i + 1]).array() - kRadius;
  box.max_ = points[i].cwiseMax(points[i + 1]).array() + kRadius;
  return box;
}

struct Lister {
  std::uint32_t neighbours;
  Pairs found;

  void add(std::uint32_t i, std::uint32_t j) {
    if (i > j) std::swap(i, j);
    if (j - i > neighbours) found.emplace_back(i, j);
  }

  // Pairs of leaves below two nodes; the larger box is opened.
  void between(const Node* p, const Node* q) {
    if (!p->bv.overlap(q->bv)) return;
    if (p->isLeaf() && q->isLeaf()) {
      add(static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(p->data)),
          static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(q->data)));
      return;
    }
    const bool open_q = p->isLeaf() || (!q->isLeaf() && q->bv.size() > p->bv.size());
    const Node* open = open_q ? q : p;
    const Node* other = open_q ? p : q;
    between(open->children[0], other);
    between(open->children[1], other);
  }

  void within(const Node* p) {
    if (p->isLeaf()) return;
    within(p->children[0]);
    within(p->children[1]);
    between(p->children[0], p->children[1]);
  }
};

void tree(const std::vector<Point>& points, int level, Lister& lister, int repeat, double out[2]) {
  const std::size_t n = points.size() - 1;
  std::vector<Node*> leaves(n);
  for (std::size_t i = 0; i < n; ++i) {
    leaves[i] = new Node;
    leaves[i]->bv = box_of(points, i);
    leaves[i]->parent = nullptr;
    leaves[i]->children[1] = nullptr;
    leaves[i]->data = reinterpret_cast<void*>(i);
  }
  const std::vector<Node*> in_order = leaves;
  fcl::detail::HierarchyTree<Box> tree;
  tree.init(leaves, level);
  out[0] = median_seconds(repeat, [&] {
    for (std::size_t i = 0; i < n; ++i) in_order[i]->bv = box_of(points, i);
    tree.refit();
  });
  out[1] = median_seconds(repeat, [&] {
    lister.found.clear();
    lister.within(tree.getRoot());
  });
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) return 2;
  const std::vector<Point> points = read_points(argv[1]);
  Lister lister{static_cast<std::uint32_t>(std::atoi(argv[2])), {}};
  const int repeat = std::atoi(argv[3]);
  // Its ways to build a tree (top down, three by Morton codes) give trees of different worth: the best counts.
  double best[2] = {0, 0};
  for (int level = 0; level < 4; ++level) {
    double times[2];
    tree(points, level, lister, repeat, times);
    if (level == 0 || times[0] + times[1] < best[0] + best[1]) std::copy(times, times + 2, best);
  }
  std::printf("fcl refit %.6f\nfcl list %.6f\nfcl pairs %zu\n", best[0], best[1], lister.found.size());
}
