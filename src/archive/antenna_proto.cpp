/// What the engine makes for antennas: their commands and accounts.

#include <archive/proto_field.hpp>

namespace downrange::archive {

void to_proto(const SlavingCommand& in, record::SlavingCommand& out) {
  put(in.antenna, out.mutable_antenna());
  put(in.target, out.mutable_target());
  out.set_tick_ns(in.tick.ns);
  out.set_apply_at_ns(in.apply_at.ns);
  out.set_valid_until_ns(in.valid_until.ns);
  out.set_data_epoch_ns(in.data_epoch.ns);
  out.set_age_s(in.age_s);
  out.set_azimuth_rad(in.azimuth_rad);
  out.set_elevation_rad(in.elevation_rad);
  out.set_range_m(in.range_m);
  out.set_azimuth_rate_rad_s(in.azimuth_rate_rad_s);
  out.set_elevation_rate_rad_s(in.elevation_rate_rad_s);
  out.set_range_rate_m_s(in.range_rate_m_s);
  out.set_sigma_azimuth_rad(in.sigma_azimuth_rad);
  out.set_sigma_elevation_rad(in.sigma_elevation_rad);
  out.set_source(wire<record::SlavingSource>(in.source));
  out.set_limits(in.limits);
  out.set_azimuth_acceleration_rad_s2(in.azimuth_acceleration_rad_s2);
  out.set_elevation_acceleration_rad_s2(in.elevation_acceleration_rad_s2);
  out.set_acceleration_valid(in.acceleration_valid);
  out.set_probability_in_beam(in.probability_in_beam);
  out.set_probability_valid(in.probability_valid);
  out.set_bound_rad(in.bound_rad);
  out.set_bound_valid(in.bound_valid);
  put(in.chain, out.mutable_chain());
  out.set_off_target_rad(in.off_target_rad);
  out.set_mount_azimuth_rad(in.mount_azimuth_rad);
  out.set_mount_elevation_rad(in.mount_elevation_rad);
}

SlavingCommand from_proto(const record::SlavingCommand& in, Defect& defect) {
  SlavingCommand out;
  out.antenna = name(in.antenna(), "antenna", defect);
  out.target = name(in.target(), "target", defect);
  out.tick = {in.tick_ns()};
  out.apply_at = {in.apply_at_ns()};
  out.valid_until = {in.valid_until_ns()};
  out.data_epoch = {in.data_epoch_ns()};
  out.age_s = in.age_s();
  out.azimuth_rad = in.azimuth_rad();
  out.elevation_rad = in.elevation_rad();
  out.range_m = in.range_m();
  out.azimuth_rate_rad_s = in.azimuth_rate_rad_s();
  out.elevation_rate_rad_s = in.elevation_rate_rad_s();
  out.range_rate_m_s = in.range_rate_m_s();
  out.sigma_azimuth_rad = in.sigma_azimuth_rad();
  out.sigma_elevation_rad = in.sigma_elevation_rad();
  out.source = enumerator(in.source(), SlavingSource::Nominal, "source", defect);
  out.limits = byte(in.limits(), "limits", defect);
  out.azimuth_acceleration_rad_s2 = in.azimuth_acceleration_rad_s2();
  out.elevation_acceleration_rad_s2 = in.elevation_acceleration_rad_s2();
  out.acceleration_valid = in.acceleration_valid();
  out.probability_in_beam = in.probability_in_beam();
  out.probability_valid = in.probability_valid();
  out.bound_rad = in.bound_rad();
  out.bound_valid = in.bound_valid();
  out.chain = name(in.chain(), "chain", defect);
  out.off_target_rad = in.off_target_rad();
  out.mount_azimuth_rad = in.mount_azimuth_rad();
  out.mount_elevation_rad = in.mount_elevation_rad();
  return out;
}

void to_proto(const AntennaAccount& in, record::AntennaAccount& out) {
  put(in.antenna, out.mutable_antenna());
  put(in.target, out.mutable_target());
  out.set_tick_ns(in.tick.ns);
  out.set_basis(wire<record::PassBasis>(in.basis));
  out.set_in_view(in.in_view);
  out.set_acquisition_valid(in.acquisition_valid);
  out.set_acquisition_ns(in.acquisition.ns);
  out.set_acquisition_azimuth_rad(in.acquisition_azimuth_rad);
  out.set_loss_valid(in.loss_valid);
  out.set_loss_ns(in.loss.ns);
  out.set_loss_azimuth_rad(in.loss_azimuth_rad);
  out.set_highest_valid(in.highest_valid);
  out.set_highest_elevation_rad(in.highest_elevation_rad);
  out.set_highest_ns(in.highest.ns);
  put(in.orders, out.mutable_orders());
  out.set_pass_valid(in.pass_valid);
}

AntennaAccount from_proto(const record::AntennaAccount& in, Defect& defect) {
  AntennaAccount out;
  out.antenna = name(in.antenna(), "antenna", defect);
  out.target = name(in.target(), "target", defect);
  out.tick = {in.tick_ns()};
  out.basis = enumerator(in.basis(), PassBasis::PlannedLiftoff, "basis", defect);
  out.in_view = in.in_view();
  out.acquisition_valid = in.acquisition_valid();
  out.acquisition = {in.acquisition_ns()};
  out.acquisition_azimuth_rad = in.acquisition_azimuth_rad();
  out.loss_valid = in.loss_valid();
  out.loss = {in.loss_ns()};
  out.loss_azimuth_rad = in.loss_azimuth_rad();
  out.highest_valid = in.highest_valid();
  out.highest_elevation_rad = in.highest_elevation_rad();
  out.highest = {in.highest_ns()};
  out.orders = name<Remark>(in.orders(), "orders", defect);
  out.pass_valid = in.pass_valid();
  return out;
}

}  // namespace downrange::archive
