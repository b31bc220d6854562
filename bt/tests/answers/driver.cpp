// Prints what BehaviorTree.CPP answers to each tree of a file: the answers in 4.10.0.tsv.
//
//   python3 generate.py 1 10000 > trees.txt
//   git clone -b 4.10.0 https://github.com/BehaviorTree/BehaviorTree.CPP btcpp
//   cmake -S btcpp -B build -DBUILD_TESTING=OFF -DBTCPP_EXAMPLES=OFF -DBTCPP_BUILD_TOOLS=OFF \
//       -DBTCPP_GROOT_INTERFACE=OFF -DBTCPP_SQLITE_LOGGING=OFF -DBTCPP_SHARED_LIBS=OFF
//   cmake --build build
//   g++ -std=c++17 -Ibtcpp/include driver.cpp build/libbehaviortree_cpp.a \
//       build/3rdparty/tinyxml2/libtinyxml2.a build/3rdparty/minitrace/libminitrace.a -lpthread -ldl -o driver
//   ./driver trees.txt 2>/dev/null > answers.tsv
//   STEWARD_ANSWERS=$PWD/answers.tsv cargo test -p steward-bt --test main answers
//
// With MESSAGES set, exceptions have their texts.
#include <behaviortree_cpp/bt_factory.h>
#include <fstream>
#include <iostream>
#include <sstream>
using namespace BT;
static std::string oneLine(std::string s) { for(auto& c : s) if(c == '\n' || c == '\t') c = ' '; return s; }
// A leaf that writes its constant `is` to `out`, and reads `in`.
template <typename T> struct Put : SyncActionNode {
  using SyncActionNode::SyncActionNode;
  static PortsList providedPorts() { return { InputPort<T>("is"), OutputPort<T>("out") }; }
  NodeStatus tick() override {
    T value; if(auto r = getInput("is", value); !r) throw RuntimeError(r.error());
    auto r = setOutput("out", value); if(!r) throw RuntimeError(r.error());
    return NodeStatus::SUCCESS; }
};
template <typename T> struct Get : SyncActionNode {
  using SyncActionNode::SyncActionNode;
  static PortsList providedPorts() { return { InputPort<T>("in", "{d}", "") }; }
  NodeStatus tick() override {
    T value; return getInput("in", value) ? NodeStatus::SUCCESS : NodeStatus::FAILURE; }
};
static std::string show(const Any& a) {
  if(a.empty()) return "-";
  if(a.isString()) return "'" + a.cast<std::string>() + "'";
  if(a.isIntegral()) return std::to_string(a.cast<int64_t>());
  if(a.isNumber()) { char t[64]; snprintf(t, 64, "%.6f", a.cast<double>()); return t; }
  return "?";
}
// A tree without its root element, before its answer.
static std::string pair(const std::string& xml) {
  size_t from = xml.find('>') + 1, to = xml.rfind("</root>");
  return xml.substr(from, to - from) + "\t";
}
static void run(const std::string& xml) {
  std::ostringstream sink; auto* old = std::cout.rdbuf(sink.rdbuf());
  std::string out;
  try {
    BehaviorTreeFactory f;
    f.registerNodeType<Put<int>>("PutInt"); f.registerNodeType<Put<unsigned>>("PutUnsigned");
    f.registerNodeType<Put<double>>("PutDouble"); f.registerNodeType<Put<bool>>("PutBool");
    f.registerNodeType<Put<std::string>>("PutText");
    f.registerNodeType<Get<int>>("GetInt"); f.registerNodeType<Get<unsigned>>("GetUnsigned");
    f.registerNodeType<Get<double>>("GetDouble"); f.registerNodeType<Get<bool>>("GetBool");
    f.registerNodeType<Get<std::string>>("GetText");
    f.registerBehaviorTreeFromText(xml);
    Tree tree = f.createTree("T");
    for(int i = 0; i < 3; i++) {
      try { out += toStr(tree.tickOnce())[0]; }
      catch(std::exception& e) {
        out += "!"; if(getenv("MESSAGES")) out += "(" + oneLine(e.what()) + ")";
        std::cout.rdbuf(old); std::cout << pair(xml) << out << "\n"; return;
      }
    }
    for(auto k : {"a","b","c","d"}) {
      auto e = tree.rootBlackboard()->getEntry(k);
      out += std::string(" ") + k + "=" + (e ? show(e->value) : "-");
    }
  } catch(std::exception& e) { out = "refused"; if(getenv("MESSAGES")) out += "(" + oneLine(e.what()) + ")"; }
  std::cout.rdbuf(old);
  std::cout << pair(xml) << out << "\n";
}
int main(int, char** v) { std::ifstream in(v[1]); std::string line; while(std::getline(in, line)) if(!line.empty()) run(line); }
