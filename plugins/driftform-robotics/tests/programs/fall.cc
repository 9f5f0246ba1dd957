// Reads a world, or a model, as Gazebo's physics does: libsdformat, the meshes of ign-common, and the plugin for DART.
//
// fall FILE MODEL STEPS prints what DART has of the model's link, one item a line:
//   models and meshes    how many were constructed
//   mass, inertia        from the response to forces and torques in one step, kg and kg m2, rows about the COG
//   fall t z v           height and vertical velocity of the link, m and m/s, after each tenth of the steps
//   end x y z            position of the link at the end, m

#include <chrono>
#include <iostream>
#include <string>
#include <vector>

#include <ignition/common/MeshManager.hh>
#include <ignition/math/eigen3/Conversions.hh>
#include <ignition/physics/FindFeatures.hh>
#include <ignition/physics/ForwardStep.hh>
#include <ignition/physics/GetEntities.hh>
#include <ignition/physics/Link.hh>
#include <ignition/physics/RequestEngine.hh>
#include <ignition/physics/mesh/MeshShape.hh>
#include <ignition/physics/sdf/ConstructModel.hh>
#include <ignition/physics/sdf/ConstructWorld.hh>
#include <ignition/plugin/Loader.hh>
#include <sdf/sdf.hh>

namespace physics = ignition::physics;

using Features = physics::FeatureList<
    physics::ForwardStep, physics::GetLinkFromModel, physics::LinkFrameSemantics,
    physics::AddLinkExternalForceTorque, physics::mesh::AttachMeshShapeFeature,
    physics::sdf::ConstructSdfModel, physics::sdf::ConstructSdfWorld>;
using Clock = std::chrono::steady_clock;

struct Scene
{
  physics::World3dPtr<Features> world;
  physics::Link3dPtr<Features> link;
  int models = 0;
  int meshes = 0;

  void Step(double _seconds)
  {
    physics::ForwardStep::Input input;
    physics::ForwardStep::State state;
    physics::ForwardStep::Output output;
    input.Get<Clock::duration>() =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(_seconds));
    this->world->Step(output, state, input);
  }
};

// DART constructs no mesh from SDF: Gazebo loads and attaches meshes after the rest of a link.
sdf::Model WithoutMeshes(sdf::Model _model)
{
  std::vector<sdf::Link> links;
  for (uint64_t i = 0; i < _model.LinkCount(); ++i)
  {
    sdf::Link link = *_model.LinkByIndex(i);
    std::vector<sdf::Collision> kept;
    for (uint64_t j = 0; j < link.CollisionCount(); ++j)
    {
      if (!link.CollisionByIndex(j)->Geom()->MeshShape())
        kept.push_back(*link.CollisionByIndex(j));
    }
    link.ClearCollisions();
    for (const auto &collision : kept)
      link.AddCollision(collision);
    links.push_back(link);
  }
  _model.ClearLinks();
  for (const auto &link : links)
    _model.AddLink(link);
  return _model;
}

void AttachMeshes(Scene &_scene, physics::Model3dPtr<Features> _model, const sdf::Model &_sdf,
                  const std::string &_folder)
{
  for (uint64_t i = 0; i < _sdf.LinkCount(); ++i)
  {
    const auto *link = _sdf.LinkByIndex(i);
    for (uint64_t j = 0; j < link->CollisionCount(); ++j)
    {
      const auto *collision = link->CollisionByIndex(j);
      const auto *shape = collision->Geom()->MeshShape();
      if (!shape)
        continue;
      const auto *mesh =
          ignition::common::MeshManager::Instance()->Load(_folder + "/" + shape->Uri());
      if (!mesh)
        throw std::runtime_error("no mesh " + shape->Uri());
      auto made = _model->GetLink(link->Name())
                      ->AttachMeshShape(collision->Name(), *mesh,
                                        ignition::math::eigen3::convert(collision->RawPose()),
                                        ignition::math::eigen3::convert(shape->Scale()));
      if (!made)
        throw std::runtime_error("DART has no mesh " + shape->Uri());
      ++_scene.meshes;
    }
  }
}

Scene Make(physics::Engine3dPtr<Features> _engine, const sdf::Root &_root, const std::string &_name,
           const std::string &_folder)
{
  Scene scene;
  std::vector<const sdf::Model *> models;
  if (_root.WorldCount() > 0)
  {
    const auto *world = _root.WorldByIndex(0);
    sdf::World bare;
    bare.SetName(world->Name());
    bare.SetGravity(world->Gravity());
    scene.world = _engine->ConstructWorld(bare);
    for (uint64_t i = 0; i < world->ModelCount(); ++i)
      models.push_back(world->ModelByIndex(i));
  }
  else
  {
    scene.world = _engine->ConstructWorld(sdf::World());
    models.push_back(_root.Model());
  }
  for (const auto *sdf : models)
  {
    auto model = scene.world->ConstructModel(WithoutMeshes(*sdf));
    AttachMeshes(scene, model, *sdf, _folder);
    ++scene.models;
    if (sdf->Name() == _name)
      scene.link = model->GetLink(sdf->LinkByIndex(0)->Name());
  }
  if (!scene.link)
    throw std::runtime_error("no model " + _name);
  return scene;
}

int main(int _argc, char **_argv)
{
  if (_argc != 4)
    throw std::runtime_error("usage: fall FILE MODEL STEPS");
  const std::string file = _argv[1], name = _argv[2];
  const int steps = std::stoi(_argv[3]);
  const std::string folder = file.substr(0, file.find_last_of('/'));

  sdf::Root root;
  const auto errors = root.Load(file);
  for (const auto &error : errors)
    std::cerr << error.Message() << "\n";
  if (!errors.empty())
    return 3;
  double dt = 0.001;
  if (root.WorldCount() > 0)
    dt = root.WorldByIndex(0)->PhysicsDefault()->MaxStepSize();

  ignition::plugin::Loader loader;
  loader.LoadLib(DART);
  auto engine = physics::RequestEngine3d<Features>::From(
      loader.Instantiate("ignition::physics::dartsim::Plugin"));
  if (!engine)
    return 4;

  std::cout.precision(12);
  // From rest each push changes the velocity by its acceleration times the step.
  const double small = 1e-6;
  Eigen::Matrix3d pushed, turned;
  Eigen::Vector3d fallen;
  for (int k = -1; k < 6; ++k)
  {
    auto scene = Make(engine, root, name, folder);
    const auto axis = [](int i) -> Eigen::Vector3d { return Eigen::Vector3d::Unit(i); };
    const Eigen::Matrix3d R = scene.link->FrameDataRelativeToWorld().pose.linear();
    if (k >= 0 && k < 3)
      scene.link->AddExternalForce(axis(k), physics::FrameID::World(), Eigen::Vector3d::Zero());
    if (k >= 3)
      scene.link->AddExternalTorque(R * axis(k - 3), physics::FrameID::World());
    scene.Step(small);
    const auto now = scene.link->FrameDataRelativeToWorld();
    if (k < 0)
      fallen = now.linearVelocity;
    else if (k < 3)
      pushed.col(k) = (now.linearVelocity - fallen) / small;
    else
      turned.col(k - 3) = R.transpose() * now.angularVelocity / small;
  }
  std::cout << "mass " << 3 / pushed.trace() << "\n";
  std::cout << "inertia";
  for (const double value : Eigen::Matrix3d(turned.inverse()).reshaped())
    std::cout << " " << value;
  std::cout << "\n";

  auto scene = Make(engine, root, name, folder);
  std::cout << "models " << scene.models << "\nmeshes " << scene.meshes << "\n";
  for (int i = 1; i <= steps; ++i)
  {
    scene.Step(dt);
    const auto now = scene.link->FrameDataRelativeToWorld();
    if (i % (steps / 10) == 0)
      std::cout << "fall " << i * dt << " " << now.pose.translation()[2] << " "
                << now.linearVelocity[2] << "\n";
  }
  const Eigen::Vector3d place = scene.link->FrameDataRelativeToWorld().pose.translation();
  std::cout << "end " << place[0] << " " << place[1] << " " << place[2] << "\n";
}
