// A loop at its frequency: the capacitors that tune it, its quality and what its losses cost.
#pragma once

namespace vacuform {

// MHz of the hydrogen nucleus at 1.5, 3 and 7 T.
inline constexpr double proton_mhz_per_tesla = 42.577478;

double angular_frequency(double mhz);  // 1/s

// Of all capacitors of a loop in series, pF; each of n equal ones is n times as large.
double tuning_pf(double inductance_nh, double frequency_mhz);

// w L / R.
double quality(double inductance_nh, double frequency_mhz, double resistance_ohm);

// What the losses of the coil add to the noise of the body, dB: 10 log10(1 + R_coil / R_body), which is
// 10 log10(Qr / (Qr - 1)) with the ratio Qr of the unloaded to the loaded quality.
double noise_figure_db(double coil_ohm, double body_ohm);

// The two capacitors that bring a loop to `port_ohm`, pF: one across the port, w C = sqrt((Z - R) / R) / Z, and all others in
// series, which leave the loop the reactance sqrt(R (Z - R)). A loop with more resistance than the port has none across it.
struct Match {
  double port_pf = 0, series_pf = 0;
};
Match match(double inductance_nh, double loop_ohm, double port_ohm, double frequency_mhz);

// The current that one tuned loop drives in another, as a share of its own: k w L / (R + Zb), with Zb the impedance that a
// preamplifier shows to it; and the same in dB less than without the preamplifier.
double coupled_current(double k, double inductance_nh, double frequency_mhz, double resistance_ohm,
                       double blocking_ohm);

// The nearest value of the E24 series (IEC 60063), pF, and how far the loop is then off its frequency, as a ratio less 1.
struct StandardValue {
  double pf = 0;
  double detuning = 0;
};
StandardValue standard_value(double wanted_pf);

}  // namespace vacuform
