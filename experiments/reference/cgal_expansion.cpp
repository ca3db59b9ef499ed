// Alpha-expansion by CGAL: cgal_expansion adjacency-list|maxflow PROBLEM LABELS
//
//     E(l) = sum_j cost(j, l_j) + sum_e weight_e [l_j != l_k],  e = (j, k)
//
// PROBLEM: n, m, p (int64), costs (n x m float64, not negative), pairs (2 x p int32, each pair once), weights (p float64),
// the labels at the start (n int32). LABELS: the labels at the end (n int32). Prints the seconds of the construction
// of the graph and of the expansion.
//
// Headers: libcgal-dev on Debian. alpha_expansion_graphcut.h is LGPL, the MAXFLOW library (graph.h) GPL.

#include <CGAL/boost/graph/alpha_expansion_graphcut.h>
#include <CGAL/property_map.h>

#include <boost/graph/adjacency_list.hpp>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

namespace MaxFlow {
#include <CGAL/Surface_mesh_segmentation/internal/auxiliary/graph.h>
}

namespace CGAL {

// What the expansion calls with Alpha_expansion_MaxFlow_tag, in place of CGAL's own class in Alpha_expansion_MaxFlow_tag.h:
// that one, since CGAL 5.5, clears a graph without resetting its flow, so that the cut of every move includes those
// before, no move after the first counts as progress, and the labels stay far from a minimum.
class Alpha_expansion_MaxFlow_impl {
public:
    using Vertex_descriptor = MaxFlow::Graph::node_id;

    void clear_graph() { graph_.emplace(); }
    void init_vertices() {}
    Vertex_descriptor add_vertex() { return graph_->add_node(); }
    void add_tweight(Vertex_descriptor v, double source, double sink) { graph_->add_tweights(v, source, sink); }
    void add_edge(Vertex_descriptor v, Vertex_descriptor w, double there, double back) { graph_->add_edge(v, w, there, back); }
    double max_flow() { return graph_->maxflow(); }

    template <typename Labels, typename Vertex>
    void update(Labels labels, const std::vector<Vertex_descriptor>& nodes, Vertex vertex, std::size_t index, std::size_t alpha) {
        if (graph_->what_segment(nodes[index]) == MaxFlow::Graph::SINK) {
            put(labels, vertex, alpha);
        }
    }

private:
    std::optional<MaxFlow::Graph> graph_;
};

}  // namespace CGAL

namespace {

using Weighted = boost::property<boost::edge_weight_t, double>;
using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::undirectedS, boost::no_property, Weighted>;

[[noreturn]] void fail(const std::string& message) {
    std::cerr << message << '\n';
    std::exit(1);
}

template <typename T>
std::vector<T> read(std::istream& file, std::size_t count) {
    std::vector<T> values(count);
    if (!file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(count * sizeof(T)))) {
        fail("the problem is too short");
    }
    return values;
}

template <typename Tag>
void expand(const Graph& graph, const std::vector<std::vector<double>>& costs, std::vector<std::size_t>& labels) {
    CGAL::alpha_expansion_graphcut(
        graph,
        get(boost::edge_weight, graph),
        CGAL::make_property_map(costs),
        CGAL::make_property_map(labels),
        CGAL::parameters::vertex_index_map(get(boost::vertex_index, graph)).implementation_tag(Tag()));
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 4) {
        fail("usage: cgal_expansion adjacency-list|maxflow PROBLEM LABELS");
    }
    const std::string implementation = arguments[1];
    std::ifstream problem(arguments[2], std::ios::binary);
    const auto sizes = read<std::int64_t>(problem, 3);
    const auto n = static_cast<std::size_t>(sizes[0]);
    const auto m = static_cast<std::size_t>(sizes[1]);
    const auto p = static_cast<std::size_t>(sizes[2]);
    const auto flat = read<double>(problem, n * m);
    const auto ends = read<std::int32_t>(problem, 2 * p);
    const auto weights = read<double>(problem, p);
    const auto start = read<std::int32_t>(problem, n);
    std::vector<std::vector<double>> costs;
    for (std::size_t j = 0; j < n; ++j) {
        costs.emplace_back(flat.begin() + static_cast<std::ptrdiff_t>(j * m), flat.begin() + static_cast<std::ptrdiff_t>((j + 1) * m));
    }
    std::vector<std::size_t> labels(start.begin(), start.end());

    const auto before = std::chrono::steady_clock::now();
    Graph graph(n);
    for (std::size_t e = 0; e < p; ++e) {
        add_edge(static_cast<std::size_t>(ends[e]), static_cast<std::size_t>(ends[p + e]), Weighted(weights[e]), graph);
    }
    if (implementation == "maxflow") {
        expand<CGAL::Alpha_expansion_MaxFlow_tag>(graph, costs, labels);
    } else if (implementation == "adjacency-list") {
        expand<CGAL::Alpha_expansion_boost_adjacency_list_tag>(graph, costs, labels);
    } else {
        fail("unknown implementation: " + implementation);
    }
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - before;

    const std::vector<std::int32_t> result(labels.begin(), labels.end());
    std::ofstream output(arguments[3], std::ios::binary);
    output.write(reinterpret_cast<const char*>(result.data()), static_cast<std::streamsize>(n * sizeof(std::int32_t)));
    if (!output.flush()) {
        fail("cannot write the labels");
    }
    std::cout << elapsed.count() << '\n';
}
