// Lamps: tungsten, LED, discharge, and supplies that chop. Needs turns.h, motion.h and filter.h.
//
// Every lamp stores its state at the last change of its input and computes from there in closed form (see motion.h).

// Tungsten.
//
// The filament's heat balance with power laws, C dT/dt = v^2 P (T/Tn)^-r - P (T/Tn)^p with C ~ T^q, has two solution
// curves for all lamps and all voltages: one heats from 0 K, one cools from infinite temperature. With theta =
// v^(2/(p+r)) its equilibrium over the full temperature Tn, y = T / (theta Tn), and x = theta^(p-q-1) t / tau: (p+r)
// dy/dx = y^-q (y^-r - y^p), and near y = 1 a deviation decays as exp(-x). So a step is: x of y, plus dx, then y of x.
// Both curves are tabulated over x in octaves of 16 intervals, like the bits of a float. So a look-up needs no
// logarithm, and the error stays relative near 0 K, where y ~ x^(1/(1+q+r)). x of y is needed only for a new voltage.
// It is the logarithm of |1 - y| plus a tabulated remainder. In double, Newton's method on the curve follows, so that
// steps add up. Above y = 2.5, which occurs only in a lamp that is almost off, x comes from its series in y^-(p+r).
//
// Error of the table: 4e-4 K of the lamp's temperature. Error of table and float rounding together, against an adaptive
// solver at 1e-13: see lamp_test.cpp. Cost: one look-up while the voltage is constant; two logarithms, two exponentials
// and one look-up more when it changes.
// Source: r = 1.215 (resistivity of tungsten), p = 4.6 and q = 0.15 for radiation and heat capacity; these give P ~
// v^1.58 (makers: 1.6), T ~ v^0.34 (makers, of colour temperature: 0.42) and light ~ v^2.8 (makers: 3.4), and an inrush
// of 18 times the current.

FL_CONST Real kFilamentR = Real(1.215);
FL_CONST Real kFilamentP = Real(4.6);
FL_CONST Real kFilamentQ = Real(0.15);
FL_CONST Real kFilamentPR = Real(5.815);  // p + r: the decay at full, 1 / tau, over the rate P / (C Tn)
FL_CONST Real kFilamentC = Real(3.45);    // c = p - q - 1: s = y^-c / c for a lamp that only cools
FL_CONST Real kFilamentAmbientK = Real(293.15);

FL_CONST Real kFilamentFar = Real(2.5);                   // end of the tables
FL_CONST Real kFilamentFarS = Real(0.01230479182093496);  // s between infinite y and kFilamentFar

// The curves as one list of numbers. C++ has the list here; a shader reads it through its own fl_filament(), because
// compilers copy a long list into each function that reads it (llvmpipe took ten times as long for it).
// - y over x: 2^-14 to 2^5 for a lamp that heats, and from kFilamentCools on 2^-4 to 2^5 for one that cools; 16 nodes
//   per octave, from the curve's hypergeometric series and Newton's method.
// - Its slopes, each over the interval behind the node.
// - x + ln |1 - y| at y = i / 48 up to 1, and beyond at y = (i - 1) / 48; then its slopes over one interval.
FL_CONST uint kFilamentCools = uint(305);
FL_CONST uint kFilamentYSlope = uint(450);
FL_CONST uint kFilamentX = uint(900);
FL_CONST uint kFilamentXSlope = uint(1022);
FL_CONST uint kFilamentCount = uint(1144);
#ifdef __cplusplus
// clang-format off
FL_CONST Real kFilament[kFilamentCount] = {
    Real(0.01129264185194), Real(0.01158586058607), Real(0.01186928418375), Real(0.01214375816482),
    Real(0.01241001493972), Real(0.01266869378128), Real(0.01292035649549), Real(0.01316549986918),
    Real(0.01340456566797), Real(0.01363794874779), Real(0.01386600369647), Real(0.0140890503178),
    Real(0.01430737819481), Real(0.01452125051406), Real(0.01473090729174), Real(0.01493656811188),
    Real(0.01513843446371), Real(0.01553151100401), Real(0.01591145660179), Real(0.01627940472489),
    Real(0.01663633721155), Real(0.0169831110437), Real(0.01732047935449), Real(0.01764910811516),
    Real(0.01796958953792), Real(0.01828245294977), Real(0.01858817369606), Real(0.01888718049211),
    Real(0.01917986154061), Real(0.01946656965824), Real(0.01974762660046), Real(0.02002332673228),
    Real(0.02029394016157), Real(0.02082088182163), Real(0.02133022069967), Real(0.02182347627441),
    Real(0.02230196475631), Real(0.02276683497885), Real(0.02321909656023), Real(0.02365964227314),
    Real(0.024089266012), Real(0.02450867737005), Real(0.024918513575), Real(0.02531934934435), Real(0.02571170508607),
    Real(0.02609605377118), Real(0.02647282673134), Real(0.02684241857972), Real(0.02720519141143),
    Real(0.02791158694642), Real(0.02859438494188), Real(0.02925562234622), Real(0.0298970636151),
    Real(0.03052024882574), Real(0.03112653142925), Real(0.03171710823868), Real(0.03229304351504),
    Real(0.03285528850878), Real(0.03340469746023), Real(0.03394204081117), Real(0.03446801619836),
    Real(0.03498325766657), Real(0.03548834344066), Real(0.03598380252222), Real(0.03647012032052),
    Real(0.03741708407072), Real(0.03833241396461), Real(0.03921884064841), Real(0.04007872947619),
    Real(0.04091414500981), Real(0.04172690162815), Real(0.04251860372773), Real(0.04329067801154),
    Real(0.04404439968537), Real(0.04478091390736), Real(0.04550125349895), Real(0.04620635368221),
    Real(0.04689706443053), Real(0.04757416088749), Real(0.04823835221009), Real(0.04889028911727),
    Real(0.05015974834642), Real(0.05138680057317), Real(0.05257510638537), Real(0.05372783667573),
    Real(0.05484775910779), Real(0.05593730596042), Real(0.05699862801913), Real(0.05803363786098),
    Real(0.0590440449724), Real(0.06003138450347), Real(0.06099704101047), Real(0.06194226821212),
    Real(0.06286820554639), Real(0.06377589213765), Real(0.06466627865138), Real(0.06554023741357),
    Real(0.06724202019768), Real(0.06888695394222), Real(0.07047994587425), Real(0.07202524675647),
    Real(0.07352656679968), Real(0.07498716661233), Real(0.07640992944484), Real(0.07779741921556),
    Real(0.07915192758819), Real(0.08047551251857), Real(0.08177003008289), Real(0.08303716096209),
    Real(0.08427843263725), Real(0.08549523811323), Real(0.08668885181078), Real(0.08786044313198),
    Real(0.0901417794059), Real(0.09234690613818), Real(0.09448240174103), Real(0.09655396459851),
    Real(0.09856656845388), Real(0.1005245843327), Real(0.1024318773905), Real(0.1042918846999), Real(0.1061076783604),
    Real(0.107882017173), Real(0.1096173893073), Real(0.1113160478057), Real(0.112980040337), Real(0.1146112342976),
    Real(0.1162113381146), Real(0.1177819194317), Real(0.1208401727109), Real(0.1237962616824), Real(0.1266590050312),
    Real(0.1294360417146), Real(0.1321340392678), Real(0.1347588572482), Real(0.1373156770662), Real(0.1398091062622),
    Real(0.1422432631102), Real(0.1446218458892), Real(0.1469481900818), Real(0.1492253159691), Real(0.151455968518),
    Real(0.153642651029), Real(0.1557876536964), Real(0.1578930779859), Real(0.161992776298), Real(0.165955509801),
    Real(0.169793100051), Real(0.1735157871138), Real(0.1771325088102), Real(0.1806511198236), Real(0.1840785657437),
    Real(0.1874210228574), Real(0.1906840115633), Real(0.1938724892348), Real(0.1969909268977), Real(0.200043373034),
    Real(0.2030335070524), Real(0.2059646843963), Real(0.2088399748288), Real(0.2116621951134), Real(0.217157591707),
    Real(0.2224693224411), Real(0.2276132318629), Real(0.2326030444605), Real(0.237450739007), Real(0.2421668422846),
    Real(0.2467606624002), Real(0.251240476182), Real(0.2556136812172), Real(0.2598869203402), Real(0.2640661844223),
    Real(0.2681568979038), Real(0.2721639904744), Real(0.2760919575416), Real(0.2799449115543), Real(0.2837266258128),
    Real(0.2910899529243), Real(0.2982066481873), Real(0.3050979306472), Real(0.3117821774457), Real(0.3182754256433),
    Real(0.3245917659675), Real(0.33074365558), Real(0.3367421692877), Real(0.3425972033542), Real(0.3483176423785),
    Real(0.3539114970885), Real(0.3593860189981), Real(0.364747796496), Real(0.3700028359055), Real(0.3751566302842),
    Real(0.3802142181525), Real(0.3900589511998), Real(0.3995700030159), Real(0.4087756643602), Real(0.417700417927),
    Real(0.4263656110502), Real(0.4347899835368), Real(0.4429900869462), Real(0.4509806213554), Real(0.4587747085863),
    Real(0.4663841159275), Real(0.473819440867), Real(0.4810902648143), Real(0.4882052819321), Real(0.4951724078228),
    Real(0.5019988717825), Real(0.5086912955542), Real(0.5216978679682), Real(0.5342352957112), Real(0.5463405096682),
    Real(0.5580453670827), Real(0.5693775543703), Real(0.580361295738), Real(0.5910179162807), Real(0.6013662944537),
    Real(0.6114232293462), Real(0.6212037415595), Real(0.6307213217794), Real(0.6399881377281), Real(0.6490152076961),
    Real(0.6578125470066), Real(0.6663892923851), Real(0.6747538081584), Real(0.6908762805864), Real(0.7062345971009),
    Real(0.7208757253062), Real(0.7348405361538), Real(0.7481650137064), Real(0.7608811987226), Real(0.7730179313924),
    Real(0.7846014402101), Real(0.7956558113804), Real(0.8062033643642), Real(0.8162649529296), Real(0.8258602065765),
    Real(0.8350077239067), Real(0.8437252270713), Real(0.8520296845826), Real(0.8599374083741), Real(0.8746250592095),
    Real(0.8879080350873), Real(0.8998990504965), Real(0.9107044079552), Real(0.9204243688835), Real(0.9291533212252),
    Real(0.9369798484612), Real(0.9439867681373), Real(0.9502511815665), Real(0.9558445575142), Real(0.9608328596253),
    Real(0.9652767187217), Real(0.9692316457732), Real(0.9727482784183), Real(0.9758726526786), Real(0.9786464913977),
    Real(0.9832896733763), Real(0.9869366445688), Real(0.9897959863418), Real(0.9920345900731), Real(0.9937852249085),
    Real(0.9951530331639), Real(0.9962209788544), Real(0.9970543399), Real(0.9977043636972), Real(0.998211212289),
    Real(0.9986063170621), Real(0.998914250271), Real(0.9991542057685), Real(0.9993411664199), Real(0.9994868219871),
    Real(0.9996002892892), Real(0.9997575234599), Real(0.9998529159187), Real(0.9999107836133), Real(0.999945885546),
    Real(0.999967177196), Real(0.999980091695), Real(0.999987924904), Real(0.9999926760478), Real(0.9999955577851),
    Real(0.9999973056556), Real(0.9999983657957), Real(0.9999990088043), Real(0.9999993988092), Real(0.9999996353592),
    Real(0.9999997788342), Real(0.9999998658561), Real(0.9999999506512), Real(0.9999999818456), Real(0.9999999933214),
    Real(0.9999999975431), Real(0.9999999990961), Real(0.9999999996675), Real(0.9999999998777), Real(0.999999999955),
    Real(0.9999999999834), Real(0.9999999999939), Real(0.9999999999978), Real(0.9999999999992), Real(0.9999999999997),
    Real(0.9999999999999), Real(1), Real(1), Real(2.5996855109), Real(2.554516712211), Real(2.512660527924),
    Real(2.473710077646), Real(2.437326662219), Real(2.403225585002), Real(2.371165441429), Real(2.340939912548),
    Real(2.312371395857), Real(2.285306004153), Real(2.259609596609), Real(2.235164598243), Real(2.211867428303),
    Real(2.189626403766), Real(2.168360017103), Real(2.14799551145), Real(2.12846769405), Real(2.091693364522),
    Real(2.057632675848), Real(2.025952659165), Real(1.996376128668), Real(1.968670082077), Real(1.942636938369),
    Real(1.918107823944), Real(1.894937361842), Real(1.872999580107), Real(1.852184664617), Real(1.832396356889),
    Real(1.813549850055), Real(1.795570073522), Real(1.778390283851), Real(1.761950898931), Real(1.746198527111),
    Real(1.716567455286), Real(1.689165847942), Real(1.663720911924), Real(1.640005515171), Real(1.617828694385),
    Real(1.597028484249), Real(1.5774664228), Real(1.559023286718), Real(1.54159574243), Real(1.525093688253),
    Real(1.509438124379), Real(1.494559430534), Real(1.48039596176), Real(1.466892894805), Real(1.454001273652),
    Real(1.441677214615), Real(1.418577717892), Real(1.39732193961), Real(1.377685310006), Real(1.359480699158),
    Real(1.34255064191), Real(1.326761463636), Real(1.311998778531), Real(1.298163995105), Real(1.285171571727),
    Real(1.272946838181), Real(1.261424249602), Real(1.250545974384), Real(1.240260742734), Real(1.230522900558),
    Real(1.221291626543), Real(1.212530280005), Real(1.196288516074), Real(1.181569350094), Real(1.168184111822),
    Real(1.155975131729), Real(1.144809351344), Real(1.134573492701), Real(1.125170353781), Real(1.11651593042),
    Real(1.108537153795), Real(1.101170092562), Real(1.094358510036), Real(1.08805269568), Real(1.082208510751),
    Real(1.076786602723), Real(1.071751753911), Real(1.067072337682), Real(1.058668581126), Real(1.051378447966),
    Real(1.045039600902), Real(1.039516976011), Real(1.034697329127), Real(1.030485078203), Real(1.026799085623),
    Real(1.023570134019), Real(1.020738921785), Real(1.018254453663), Real(1.016072735633), Real(1.014155707041),
    Real(1.012470359751), Real(1.010988006276), Real(1.009683667692), Real(1.008535558724), Real(1.006634309463),
    Real(1.005158850984), Real(1.004012914114), Real(1.003122357551), Real(1.002429938437), Real(1.001891375084),
    Real(1.001472360785), Real(1.001146285858), Real(1.000892492088), Real(1.000694930363), Real(1.000541125523),
    Real(1.000421376367), Real(1.000328136344), Real(1.000255533498), Real(1.000198997959), Real(1.000154972653),
    Real(1.00009398969), Real(1.00005700543), Real(1.000034574733), Real(1.000020970338), Real(1.000012719044),
    Real(1.00000771445), Real(1.000004679035), Real(1.000002837973), Real(1.000001721316), Real(1.00000104403),
    Real(1.000000633236), Real(1.000000384077), Real(1.000000232954), Real(1.000000141294), Real(1.000000085699),
    Real(1.000000051979), Real(1.000000019122), Real(1.000000007035), Real(1.000000002588), Real(1.000000000952),
    Real(1.00000000035), Real(1.000000000129), Real(1.000000000047), Real(1.000000000017), Real(1.000000000006),
    Real(1.000000000002), Real(1.000000000001), Real(1), Real(1), Real(1), Real(1), Real(1),
    Real(0.0002984313385809), Real(0.0002881696452188), Real(0.000278818045189), Real(0.0002702516560534),
    Real(0.0002623681805421), Real(0.0002550829312635), Real(0.0002483251296444), Real(0.0002420351111144),
    Real(0.0002361621858324), Real(0.0002306629809328), Real(0.0002255001414265), Real(0.0002206413016619),
    Real(0.0002160582632833), Real(0.0002117263324904), Real(0.0002076237814166), Real(0.0002037314071012),
    Real(0.0004000643357142), Real(0.0003863079468642), Real(0.0003737715903545), Real(0.00036228785411),
    Real(0.0003517196027699), Real(0.0003419533080255), Real(0.0003328940871378), Real(0.0003244619563262),
    Real(0.0003165889629496), Real(0.0003092169631925), Real(0.0003022958805483), Real(0.000295782327004),
    Real(0.000289638501045), Real(0.0002838312992152), Real(0.0002783315940626), Real(0.000273113642916),
    Real(0.0005363092008323), Real(0.0005178679721219), Real(0.0005010622667785), Real(0.0004856676593081),
    Real(0.0004715003118893), Real(0.0004584080333095), Real(0.0004462636278117), Real(0.0004349598725479),
    Real(0.0004244056731032), Real(0.0004145230843561), Real(0.0004052449758758), Real(0.0003965131835406),
    Real(0.0003882770322513), Real(0.0003804921449249), Real(0.0003731194745406), Real(0.0003661245115704),
    Real(0.0007189532609978), Real(0.0006942317355611), Real(0.0006717027230546), Real(0.0006510653682242),
    Real(0.0006320732259206), Real(0.0006145222750891), Real(0.0005982420025181), Real(0.0005830886698265),
    Real(0.0005689401597234), Real(0.0005556919823005), Real(0.0005432541453626), Real(0.000531548676567),
    Real(0.0005205076430346), Real(0.0005100715547395), Real(0.000500188066909), Real(0.0004908109175407),
    Real(0.0009637981027473), Real(0.0009306574788378), Real(0.0009004560443167), Real(0.0008727904854505),
    Real(0.0008473304283737), Real(0.0008238023711541), Real(0.0008019777310465), Real(0.0007816638185023),
    Real(0.0007626969282848), Real(0.0007449369856756), Real(0.000728263350973), Real(0.0007125714977766),
    Real(0.0006977703581639), Real(0.0006837801823409), Real(0.0006705307991361), Real(0.0006579601916805),
    Real(0.001292026646081), Real(0.001247599735319), Real(0.001207112976471), Real(0.001170025704333),
    Real(0.001135895033779), Real(0.001104354319774), Real(0.001075097134032), Real(0.001047865165155),
    Real(0.001022438956879), Real(0.0009986307310062), Real(0.0009762787630941), Real(0.0009552429295049),
    Real(0.0009354011484628), Real(0.0009166465107928), Real(0.0008988849480132), Real(0.0008820333229524),
    Real(0.001732035710887), Real(0.001672478868724), Real(0.001618204025323), Real(0.001568486387956),
    Real(0.001522732243703), Real(0.001480450083858), Real(0.001441229123724), Real(0.001404723082054),
    Real(0.001370637765137), Real(0.001338721445528), Real(0.001308757322334), Real(0.001280557551783),
    Real(0.001253958476252), Real(0.001228816777861), Real(0.001205006352415), Real(0.001182415749769),
    Real(0.002321892126755), Real(0.00224205262405), Real(0.002169293936462), Real(0.002102644437795),
    Real(0.002041308221856), Real(0.001984626393061), Real(0.001932048270992), Real(0.001883109645803),
    Real(0.00183741613398), Real(0.001794630280471), Real(0.001754461451273), Real(0.00171665783106),
    Real(0.001681000027429), Real(0.001647295914567), Real(0.001615376442592), Real(0.001585092206217),
    Real(0.003112621231137), Real(0.003005590779338), Real(0.002908052512428), Real(0.0028187039101),
    Real(0.002736478014766), Real(0.002660491539412), Real(0.002590006265636), Real(0.002524399893794),
    Real(0.002463143730426), Real(0.002405785397934), Real(0.002351935285008), Real(0.002301255818993),
    Real(0.00225345289201), Real(0.002208268948604), Real(0.002165477367919), Real(0.002124877863796),
    Real(0.004172585384196), Real(0.004029097429505), Real(0.003898333894542), Real(0.003778548678786),
    Real(0.003668311466902), Real(0.00356643816435), Real(0.003471939149267), Real(0.003383980195414),
    Real(0.003301852560915), Real(0.003224949809585), Real(0.003152749646966), Real(0.003084799539324),
    Real(0.003020705219876), Real(0.002960121422393), Real(0.002902744350189), Real(0.002848305509694),
    Real(0.005593133252312), Real(0.005400724212034), Real(0.00522537004933), Real(0.005064730036457),
    Real(0.004916886772668), Real(0.004780252929285), Real(0.004653501878486), Real(0.004535515308368),
    Real(0.004425343125266), Real(0.004322172381486), Real(0.004225302925527), Real(0.00413412812358),
    Real(0.004048119451513), Real(0.003966814072771), Real(0.003889804742671), Real(0.003816731541976),
    Real(0.007494550122287), Real(0.007236208332571), Real(0.007000708024083), Real(0.006784911478206),
    Real(0.006586248462789), Real(0.00640259121954), Real(0.006232161468765), Real(0.00607346018507),
    Real(0.005925213844734), Real(0.005786332772083), Real(0.005655878497693), Real(0.005533037914852),
    Real(0.005417102624614), Real(0.005307452283573), Real(0.005203541070289), Real(0.005104886603927),
    Real(0.01002212161518), Real(0.009672820391564), Real(0.009353984054363), Real(0.009061407991361),
    Real(0.008791648318659), Real(0.008541854301709), Real(0.008309643696291), Real(0.008093008614359),
    Real(0.007890243470328), Real(0.007699889146138), Real(0.007520689236631), Real(0.007351555407936),
    Real(0.007191539711047), Real(0.007039812260934), Real(0.006895643096083), Real(0.006758387325092),
    Real(0.01325494576), Real(0.01276536902554), Real(0.0123156224045), Real(0.01190010016363), Real(0.01151421737101),
    Real(0.01115418526862), Real(0.01081684416742), Real(0.01049953725006), Real(0.01020001396256),
    Real(0.009916355138135), Real(0.009646914306249), Real(0.009390271209981), Real(0.009145194639758),
    Real(0.008910612453178), Real(0.008685587192846), Real(0.008469296105292), Real(0.01652202929907),
    Real(0.01573198712702), Real(0.01499244800393), Real(0.01429660028435), Real(0.01363900318033),
    Real(0.01301527978217), Real(0.01242188721445), Real(0.01185594177732), Real(0.01131508401187),
    Real(0.0107973732564), Real(0.01030120434268), Real(0.009825241170122), Real(0.009368363333645),
    Real(0.008929622985613), Real(0.008508209822603), Real(0.008103422596581), Real(0.01542929183711),
    Real(0.01396596463809), Real(0.01261876123902), Real(0.01138098084575), Real(0.01024644175846),
    Real(0.009209210430285), Real(0.008263457620607), Real(0.007403398999289), Real(0.006623289198493),
    Real(0.005917446998483), Real(0.005280295955241), Real(0.00470640983674), Real(0.004190556055359),
    Real(0.003727733105053), Real(0.00331320002922), Real(0.002942497327376), Real(0.00522291920403),
    Real(0.0041064259547), Real(0.003222136888044), Real(0.002524235567796), Real(0.001974991910256),
    Real(0.001543710900703), Real(0.001205658369498), Real(0.0009410520440622), Real(0.0007341624815842),
    Real(0.0005725397979128), Real(0.0004463649779394), Real(0.0003479154491943), Real(0.0002711306383856),
    Real(0.0002112623252868), Real(0.0001645953670271), Real(0.0001282259141295), Real(0.0001997721203762),
    Real(0.0001212076331316), Real(7.353076628039e-5), Real(4.460404491101e-5), Real(2.705570071739e-5),
    Real(1.641084048656e-5), Real(9.953945923604e-6), Real(6.03747199092e-6), Real(3.661948144885e-6),
    Real(2.221097169325e-6), Real(1.34716844087e-6), Real(8.171007692924e-7), Real(4.955973330833e-7),
    Real(3.005952218186e-7), Real(1.823203081177e-7), Real(1.10582889842e-7), Real(1.341438505967e-7),
    Real(4.934877351885e-8), Real(1.815440040538e-8), Real(6.678630835733e-9), Real(2.456931001266e-9),
    Real(9.038544066694e-10), Real(3.32509454422e-10), Real(1.223233923306e-10), Real(4.500026122003e-11),
    Real(1.655467095117e-11), Real(6.090123098428e-12), Real(2.240431082133e-12), Real(8.242085344807e-13),
    Real(3.032093750738e-13), Real(1.115444954601e-13), Real(4.103492665563e-14), Real(3.019181177317e-14),
    Real(-0.04698138359908), Real(-0.043438141508), Real(-0.04034172757708), Real(-0.03761538981449),
    Real(-0.03519871420789), Real(-0.03304353909533), Real(-0.03111102948225), Real(-0.02936954612775),
    Real(-0.02779306954223), Real(-0.02636001808142), Real(-0.02505235029151), Real(-0.02385487519372),
    Real(-0.02275471666582), Real(-0.02174089338813), Real(-0.02080398641472), Real(-0.01993587386506),
    Real(-0.03825903503638), Real(-0.03535666639062), Real(-0.0328199497984), Real(-0.03058609056532),
    Real(-0.02860565993272), Real(-0.02683925279037), Real(-0.02525509427331), Real(-0.02382729651713),
    Real(-0.02253456935977), Real(-0.0213592534371), Real(-0.0202865858139), Real(-0.01930413572389),
    Real(-0.01840136637272), Real(-0.01756929128222), Real(-0.01680020231984), Real(-0.01608745263904),
    Real(-0.0308505641624), Real(-0.02846649670872), Real(-0.02638197404363), Real(-0.02454559733038),
    Real(-0.02291690537421), Real(-0.02146363987744), Real(-0.02015978704161), Real(-0.01898415111989),
    Real(-0.01791929938975), Real(-0.01695077091507), Real(-0.0160664755779), Real(-0.01525623230351),
    Real(-0.01451141044003), Real(-0.01382464850108), Real(-0.01318963156986), Real(-0.0126009136391),
    Real(-0.02410754939983), Real(-0.02213662052488), Real(-0.02041219278366), Real(-0.01889212696079),
    Real(-0.0175432422478), Real(-0.01633907717351), Real(-0.01525828603225), Real(-0.01428347078134),
    Real(-0.01340031701411), Real(-0.01259694590801), Real(-0.01186342196522), Real(-0.01119137473285),
    Real(-0.01057370499852), Real(-0.0100043543448), Real(-0.009478122750069), Real(-0.008990522996693),
    Real(-0.01707532708945), Real(-0.01544605147571), Real(-0.0140235846148), Real(-0.0127730651667),
    Real(-0.01166699192597), Real(-0.0106833874591), Real(-0.009804482686408), Real(-0.009015758490282),
    Real(-0.008305236660176), Real(-0.007662947956729), Real(-0.007080527955573), Real(-0.006550906386279),
    Real(-0.006068065771531), Real(-0.005626852047804), Real(-0.005222824607649), Real(-0.004852136544137),
    Real(-0.009022876507844), Real(-0.007817288813856), Real(-0.006789914305657), Real(-0.005910200795235),
    Real(-0.005153854545199), Real(-0.004501316508173), Real(-0.003936666611956), Real(-0.003446821658837),
    Real(-0.00302093853808), Real(-0.002649963544703), Real(-0.002326287355889), Real(-0.002043477554805),
    Real(-0.001796068856807), Real(-0.001579396822957), Real(-0.001389464740336), Real(-0.001222836081255),
    Real(-0.002153093793025), Real(-0.001670149984853), Real(-0.001296696652529), Real(-0.001007447947803),
    Real(-0.0007831408260288), Real(-0.0006090284799735), Real(-0.0004737784551164), Real(-0.000368656299886),
    Real(-0.0002869144415467), Real(-0.0002233308676876), Real(-0.0001738585704297), Real(-0.0001353577512577),
    Real(-0.0001053903937291), Real(-8.206216056707e-5), Real(-6.390039843257e-5), Real(-4.975981319986e-5),
    Real(-7.749884760718e-5), Real(-4.699945011912e-5), Real(-2.850440920625e-5), Real(-1.728798954149e-5),
    Real(-1.048539826956e-5), Real(-6.35960611674e-6), Real(-3.857255844057e-6), Real(-2.339529125139e-6),
    Real(-1.418990696698e-6), Real(-8.606593595744e-7), Real(-5.220155519896e-7), Real(-3.16618165943e-7),
    Real(-1.92038525303e-7), Real(-1.164772167414e-7), Real(-7.064698961015e-8), Real(-4.284956024804e-8),
    Real(-5.197914043682e-8), Real(-1.912205582647e-8), Real(-7.034611034204e-9), Real(-2.587888752128e-9),
    Real(-9.520310646996e-10), Real(-3.502326556201e-10), Real(-1.2884339357e-10), Real(-4.739883561713e-11),
    Real(-1.743705715792e-11), Real(-6.414734842781e-12), Real(-2.359849069205e-12), Real(-8.681399568255e-13),
    Real(-3.193708421752e-13), Real(-1.174899669458e-13), Real(-4.322214338327e-14), Real(-1.590053795407e-14),
    Real(-1.169896203374e-14),
    Real(0), Real(-0.020793642754809), Real(-0.041221420695484), Real(-0.061047320344939), Real(-0.080117635499444),
    Real(-0.098315393818959), Real(-0.11554635053696), Real(-0.13173241050287), Real(-0.14680796357619),
    Real(-0.160717634464), Real(-0.17341481238981), Real(-0.18486064823355), Real(-0.19502334804588),
    Real(-0.20387766116191), Real(-0.21140449817561), Real(-0.21759063523234), Real(-0.22242847397503),
    Real(-0.22591583475968), Real(-0.22805576639117), Real(-0.22885635969664), Real(-0.2283305553645),
    Real(-0.22649593898814), Real(-0.2233745183711), Real(-0.21899247999292), Real(-0.21337992316175),
    Real(-0.20657057182094), Real(-0.19860146523734), Real(-0.18951262987716), Real(-0.1793467356617),
    Real(-0.16814874048334), Real(-0.15596552734721), Real(-0.1428455387882), Real(-0.12883841330327),
    Real(-0.11399462845057), Real(-0.09836515501962), Real(-0.082001126295247), Real(-0.064953525950931),
    Real(-0.047272897543683), Real(-0.029009077972473), Real(-0.010210956633679), Real(0.009073738614884),
    Real(0.028798628163098), Real(0.048918840059989), Real(0.069391142644952), Real(0.090174051336839),
    Real(0.11122791086727), Real(0.13251495451947), Real(0.1539993421376), Real(0.17564717880825),
    Real(-0.77242345266759), Real(-0.75064411528394), Real(-0.72876329297136), Real(-0.70680909634932),
    Real(-0.68480776971926), Real(-0.66278373954007), Real(-0.64075967081819), Real(-0.61875652982595),
    Real(-0.59679365169965), Real(-0.57488881161116), Real(-0.55305829834989), Real(-0.53131698929187),
    Real(-0.50967842586728), Real(-0.48815488876507), Real(-0.46675747223124), Real(-0.44549615692664),
    Real(-0.42437988090827), Real(-0.40341660838717), Real(-0.38261339599429), Real(-0.36197645635511),
    Real(-0.34151121883371), Real(-0.32122238735892), Real(-0.30111399528899), Real(-0.28118945730836),
    Real(-0.26145161838082), Real(-0.24190279980842), Real(-0.22254484246563), Real(-0.20337914729413),
    Real(-0.18440671315567), Real(-0.16562817214935), Real(-0.14704382250563), Real(-0.12865365917337),
    Real(-0.11045740221796), Real(-0.092454523148835), Real(-0.074644269293682), Real(-0.057025686334593),
    Real(-0.039597639118377), Real(-0.022358830849826), Real(-0.0053078207726251), Real(0.011556959561745),
    Real(0.028237191341348), Real(0.044734654766339), Real(0.061051216460466), Real(0.077188817940012),
    Real(0.093149465063385), Real(0.10893521838915), Real(0.12454818437481), Real(0.13999050735285),
    Real(0.15526436222481), Real(0.17037194781816), Real(0.18531548085418), Real(0.20009719047919),
    Real(0.21471931331427), Real(0.22918408898222), Real(0.24349375607324), Real(0.25765054851382),
    Real(0.27165669230588), Real(0.2855144026055), Real(0.29922588111331), Real(0.31279331375021),
    Real(0.32621886859459), Real(0.33950469405874), Real(0.35265291728391), Real(0.36566564273537),
    Real(0.37854495097985), Real(0.39129289762946), Real(0.40391151243736), Real(0.4164027985316),
    Real(0.42876873177465), Real(0.44101126023715), Real(0.45313230377541), Real(0.4651337537029),
    Real(0.4770174725469),
    Real(-0.020833333333333), Real(-0.020662248106857), Real(-0.020156716346369), Real(-0.01946999206926),
    Real(-0.018651346534519), Real(-0.017728564165694), Real(-0.016720391476307), Real(-0.015640829587729),
    Real(-0.014501071164523), Real(-0.01331051848003), Real(-0.012077374062142), Real(-0.010809007016813),
    Real(-0.009512190430184), Real(-0.0081932590913616), Real(-0.0068582149088521), Real(-0.0055127962188816),
    Real(-0.0041625211337333), Real(-0.0028127116542695), Real(-0.0014685032659242), Real(-0.00013484353068528),
    Real(0.0011835175584478), Real(0.0024820431715561), Real(0.0037564292184848), Real(0.0050026261803021),
    Real(0.0062168616640439), Real(0.0073956623300112), Real(0.0085358740210969), Real(0.0096346791105119),
    Real(0.010689610279556), Real(0.011698560138574), Real(0.012659786307276), Real(0.013571911769029),
    Real(0.014433920501025), Real(0.015245148552068), Real(0.016005270886818), Real(0.016714284435632),
    Real(0.017372487880347), Real(0.01798045876761), Real(0.018539028573598), Real(0.019049256349295),
    Real(0.019512401557213), Real(0.019929896672461), Real(0.020303320067827), Real(0.020634369638431),
    Real(0.020924837550861), Real(0.02117658642827), Real(0.021391527210198), Real(0.021571598856414),
    Real(0.021718749999994), Real(0.021718750000006), Real(0.021834922597705), Real(0.021922037576011),
    Real(0.021981982429847), Real(0.02201660069741), Real(0.022027683208645), Real(0.022016960986132),
    Real(0.021986099664593), Real(0.021936695288172), Real(0.021870271342173), Real(0.021788276877292),
    Real(0.02169208558866), Real(0.021582995718597), Real(0.021462230660162), Real(0.021330940147865),
    Real(0.021190201931771), Real(0.021041023841363), Real(0.020884346155582), Real(0.020721044205201),
    Real(0.02055193114302), Real(0.020377760826063), Real(0.020199230762021), Real(0.020016985079533),
    Real(0.019831617488582), Real(0.019643674203186), Real(0.019453656803876), Real(0.01926202502205),
    Real(0.019069199432351), Real(0.018875564042673), Real(0.018681468774392), Real(0.018487231827928),
    Real(0.01829314193087), Real(0.018099460467669), Real(0.017906423491305), Real(0.017714243618566),
    Real(0.01752311181145), Real(0.01733319904796), Real(0.017144657886114), Real(0.016957623925369),
    Real(0.016772217169968), Real(0.016588543298877), Real(0.016406694847064), Real(0.016226752302906),
    Real(0.016048785126459), Real(0.01587285269325), Real(0.015699005168129), Real(0.015527284313574),
    Real(0.015357724236684), Real(0.015190352078909), Real(0.015025188652369), Real(0.014862249026462),
    Real(0.0147015430682), Real(0.014543075939587), Real(0.014386848555114), Real(0.014232858002275),
    Real(0.014081097927835), Real(0.013931558892395), Real(0.013784228695635), Real(0.013639092674455),
    Real(0.013496133976086), Real(0.013355333808101), Real(0.013216671667106), Real(0.013080125547786),
    Real(0.01294567213383), Real(0.012813286972187), Real(0.01268294463196), Real(0.012554618849162),
    Real(0.012428282658479), Real(0.012303908513077), Real(0.012181468393429), Real(0.012060933906038),
    Real(0.011942276372908), Real(0.011825466912492)};
// clang-format on
FL_FN Real fl_filament(uint index) { return kFilament[index]; }
#else
float fl_filament(uint index);
#endif

// The filament has arrived at this x: 1e-14 of the way remains.
FL_CONST Real kFilamentThere = Real(32);

// y at x, and its slope over |x|. x is negative on the cooling curve. Relative error below 3e-7.
FL_INLINE Real filament_curve(Real x, FL_OUT(Real) slope) {
  Real way = min(abs(x), Real(31.99));
  uint bits = max(float_bits(way), uint(0x38800000));  // 2^-14
  uint i = (bits >> uint(19)) - uint((127 - 14) * 16);
  if (x < Real(0)) i += kFilamentCools - uint(10 * 16);
  Real per = bits_float((uint(258) << uint(23)) - (bits & uint(0x7f800000)));  // intervals per unit of x
  Real t = (way - bits_float(bits & uint(0xfff80000))) * per;
  Real a = fl_filament(i);
  Real rise = fl_filament(i + uint(1)) - a;
  Real da = fl_filament(kFilamentYSlope + i);
  // The next octave's intervals are twice as long, so its first node's slope counts half here.
  uint next = (((bits >> uint(19)) & uint(15)) + uint(1)) >> uint(4);
  Real db = fl_filament(kFilamentYSlope + i + uint(1)) * bits_float(uint(0x3f800000) - (next << uint(23)));
  // Cubic Hermite: a + t (da + t (c2 + t c3)).
  Real both = da + db;
  Real c3 = both - Real(2) * rise;
  Real c2 = (Real(3) * rise - da) - both;
  slope = per * ((da + t * (Real(2) * c2)) + (t * t) * (Real(3) * c3));
  Real y = (a + t * da) + (t * t) * (c2 + t * c3);
  return abs(x) < kFilamentThere ? y : Real(1);
}

// x at y in (0, 2.5]: the inverse of filament_curve().
FL_INLINE Real filament_place(Real y) {
  uint cools = y < Real(1) ? uint(0) : uint(1);
  Real place = y * Real(48);
  uint first = min(uint(place), uint(119));
  Real t = place - Real(first);
  uint i = first + cools;
  Real a = fl_filament(kFilamentX + i);
  Real rise = fl_filament(kFilamentX + i + uint(1)) - a;
  Real da = fl_filament(kFilamentXSlope + i);
  Real both = da + fl_filament(kFilamentXSlope + i + uint(1));
  Real c3 = both - Real(2) * rise;
  Real c2 = (Real(3) * rise - da) - both;
  Real x = (a + t * da) + (t * t) * (c2 + t * c3);
  x -= Real(0.6931471805599453) * log2(max(abs(Real(1) - y), Real(1e-14)));
  Real side = bits_float(uint(0x3f800000) | (cools << uint(31)));
  x *= side;
  if (kSingle) return x;
  for (uint k = uint(0); k < uint(6) && abs(x) < Real(30); ++k) {
    Real slope;
    Real step = side * (filament_curve(x, slope) - y) / slope;
    x = abs(step) < Real(0.5) * abs(x) ? x - step : Real(0.5) * x;
    if (!(abs(step) > Real(1e-15) * abs(x))) break;
  }
  return x;
}

// s between infinite y and y >= 2.5, from the base-2 logarithm of y. The first omitted term is 1e-17 of the sum.
FL_FN Real filament_far_s(Real log_y) {
  Real w = exp2(-kFilamentPR * log_y);
  Real sum = Real(1) / Real(38.34);
  sum = sum * w + Real(1) / Real(32.525);
  sum = sum * w + Real(1) / Real(26.71);
  sum = sum * w + Real(1) / Real(20.895);
  sum = sum * w + Real(1) / Real(15.08);
  sum = sum * w + Real(1) / Real(9.265);
  return exp2(-kFilamentC * log_y) * (Real(1) / kFilamentC + w * sum);
}

// The inverse of filament_far_s().
FL_FN Real filament_far_log_y(Real s) {
  Real log_y = -log2(kFilamentC * s) * (Real(1) / kFilamentC);
  for (uint i = uint(0); i < uint(3); ++i) {  // Newton, from 1e-3; ds / d log2(y) is known
    Real w = exp2(-kFilamentPR * log_y);
    Real slope = Real(-0.6931471805599453) * exp2(-kFilamentC * log_y) / (Real(1) - w);
    log_y -= (filament_far_s(log_y) - s) / slope;
  }
  return log_y;
}

struct FilamentType {
  Real full_k;  // temperature at full voltage, 1000 to 3700 K
  Real tau_s;   // time constant at full: 0.003 (small) to 0.35 (2 kW)
};

struct Filament {
  Real kelvin;  // current; also the colour temperature of its light (a grey body)
  Real from_k;  // at the last change of the voltage
  Real volt;
  // Derived from the above when the voltage changes:
  Real from;       // x of from_k; if the lamp is off, (from_k / full)^-c
  Real end_k;      // equilibrium at this voltage
  Real decay_hz;   // dx / dt; if the lamp is off, the growth rate of (T / full)^-c; 0: beyond the table
  Turns since_ns;  // time since that change
};

FL_FN Filament filament_start(Real kelvin) {
  Filament filament;
  filament.kelvin = max(kelvin, kFilamentAmbientK);
  filament.from_k = filament.kelvin;
  filament.volt = Real(-1);  // none yet
  filament.from = Real(0);
  filament.end_k = Real(0);
  filament.decay_hz = Real(0);
  filament.since_ns = turns_zero();
  return filament;
}

FL_CONST Real kFilamentOff = Real(1e-4);  // lower voltages give no heat

FL_FN bool filament_takes(FilamentType type, Real volt) {
  return volt >= Real(0) && volt <= Real(10) && type.tau_s >= Real(1e-6) && type.tau_s <= Real(1e6) &&
         type.full_k >= Real(500) && type.full_k <= Real(1e4);
}

// Starts an interval of constant voltage.
FL_INLINE void filament_aim(FL_INOUT(Filament) filament, FilamentType type, Real volt) {
  filament.from_k = filament.kelvin;
  filament.volt = volt;
  filament.since_ns = turns_zero();
  Real full = filament.from_k / type.full_k;
  if (volt < kFilamentOff) {  // off: dT/dt = -T^(p-q)
    filament.from = exp2(log2(full) * -kFilamentC);
    filament.end_k = type.full_k;
    filament.decay_hz = (kFilamentC / kFilamentPR) / type.tau_s;
    return;
  }
  // Powers through base-2 logarithms.
  Real log_theta = log2(volt) * (Real(2) / kFilamentPR);
  filament.end_k = exp2(log_theta) * type.full_k;
  Real y = filament.from_k * (Real(1) / filament.end_k);
  if (y < kFilamentFar) {
    filament.from = filament_place(y);
    Real decay_hz = exp2(kFilamentC * log_theta) / type.tau_s;
    filament.decay_hz = filament.from < Real(0) ? -decay_hz : decay_hz;
  } else {
    filament.decay_hz = Real(0);
  }
}

// The temperature t_s after the start of an interval that began far above its equilibrium.
FL_FN Real filament_from_far(FL_IN(Filament) filament, FilamentType type, Real t_s) {
  Real log_theta = log2(filament.volt) * (Real(2) / kFilamentPR);
  Real s = filament_far_s(log2(filament.from_k / type.full_k) - log_theta) +
           exp2(kFilamentC * log_theta) * t_s / (type.tau_s * kFilamentPR);
  if (s < kFilamentFarS) return exp2(filament_far_log_y(s) + log_theta) * type.full_k;
  Real slope;
  return filament_curve(-kFilamentPR * s, slope) * filament.end_k;
}

FL_INLINE Real filament_at(FL_IN(Filament) filament, FilamentType type, Real t_s) {
  Real kelvin;
  if (filament.volt < kFilamentOff) {
    kelvin = exp2(log2(filament.from + filament.decay_hz * t_s) * (-Real(1) / kFilamentC)) * filament.end_k;
  } else if (filament.decay_hz != Real(0)) {
    Real slope;
    kelvin = filament_curve(filament.from + filament.decay_hz * t_s, slope) * filament.end_k;
  } else {
    kelvin = filament_from_far(filament, type, t_s);
  }
  return max(kelvin, kFilamentAmbientK);
}

// The temperature after t_s at `volt` (rms over the rated voltage, 0 to 1.2), from any temperature. Exact except for
// the table. Returns `kelvin` if t_s or volt is NaN or negative, or t_s is infinite.
FL_FN Real filament_after(Real kelvin, FilamentType type, Real volt, Real t_s) {
  if (!(t_s > Real(0)) || !(t_s < Real(1e30)) || !filament_takes(type, volt)) return kelvin;
  Filament filament = filament_start(kelvin);
  filament_aim(filament, type, volt);
  return filament_at(filament, type, t_s);
}

// `type` must be the same at every step.
FL_INLINE void filament_move(FL_INOUT(Filament) filament, FilamentType type, Real volt, Turns dt_ns) {
  if (dt_ns == turns_zero() || !filament_takes(type, volt)) return;
  if (volt != filament.volt) filament_aim(filament, type, volt);
  filament.since_ns = time_add(filament.since_ns, dt_ns);
  filament.kelvin = filament_at(filament, type, time_s(filament.since_ns));
}

// Natural logarithm of a grey body's luminous power, 500 to 4000 K: the integral of Planck's law over the CIE 1924
// luminous efficiency in steps of 10 nm, fitted in 1000 / T to 4e-4.
FL_FN Real filament_log_light(Real kelvin) {
  Real x = Real(1000) / clamp(kelvin, Real(500), Real(4000));
  return x * (Real(-26.62683571) + x * (Real(2.189450535) + x * (Real(-0.5614537306) +
                                                                 x * (Real(0.1215594012) + x * Real(-0.01031564376)))));
}

// Light over the light at full; 0 below 500 K (1e-15 of full). Relative error 6e-4.
FL_FN Real filament_light(Real kelvin, FilamentType type) {
  if (!(kelvin > Real(500))) return Real(0);
  return exp(filament_log_light(kelvin) - filament_log_light(type.full_k));
}

// The voltage whose equilibrium is this temperature. With filament_kelvin() it gives the voltage for a share of light,
// as a dimmer with a light curve needs.
FL_FN Real filament_volt(Real kelvin, FilamentType type) {
  return pow(max(kelvin, Real(0)) / type.full_k, Real(0.5) * kFilamentPR);
}

// The equilibrium temperature at a voltage.
FL_FN Real filament_rest(Real volt, FilamentType type) {
  if (!(volt > Real(1e-4))) return kFilamentAmbientK;
  return max(type.full_k * exp2(log2(volt) * (Real(2) / kFilamentPR)), kFilamentAmbientK);
}

// The temperature for a share of light, 1e-9 to 1: the inverse of filament_light(), within 1e-6 of the temperature.
FL_FN Real filament_kelvin(Real light, FilamentType type) {
  if (!(light > Real(1e-9))) return kFilamentAmbientK;
  if (light >= Real(1)) return type.full_k;
  Real wanted = log(light) + filament_log_light(type.full_k);
  // Over x = 1000 / T the logarithm of light is nearly linear; Newton's method with secants.
  Real x = Real(1000) / type.full_k;
  Real slope = Real(-24);
  Real value = filament_log_light(type.full_k);
  for (uint i = uint(0); i < uint(6); ++i) {
    Real step = (wanted - value) / slope;
    if (!(abs(step) > Real(1e-7))) break;
    Real next = filament_log_light(Real(1000) / (x + step));
    slope = (next - value) / step;
    x += step;
    value = next;
    if (!(slope < Real(-1))) break;
  }
  return Real(1000) / x;
}

// Supplies that chop.
//
// A phase-cut dimmer conducts during the last `share` of each half wave. A filament with a time constant of 10 ms or
// more responds to the rms. A shorter one, or an LED without a capacitor, is stepped per half wave or uses mains_mean.
// PWM is a strobe: shutter_step with its rate and duty.

// rms over the rated voltage.
FL_FN Real phase_cut_rms(Real share) {
  Real conducts = unit_share(share);
  Real cut = Real(1) - conducts;
  Real angle = Real(6.283185307179586477) * cut;
  return share > Real(0) ? sqrt(max(conducts + sin(angle) * Real(0.159154943091895336), Real(0))) : Real(0);
}

// Energy from the start of a half wave to `p` of it, over the energy of a whole one.
FL_FN Real mains_energy(Real p, Real cut) {
  Real angle = Real(6.283185307179586477);
  if (!(p > cut)) return Real(0);
  return (p - cut) - (sin(angle * p) - sin(angle * cut)) / angle;
}

// Mean power over an exposure; 1 for full conduction over whole half waves. phase: in half waves at the start; advance:
// half waves during it (turns_advance at twice the mains frequency).
FL_FN Real mains_mean(Turns phase, Advance advance, Real share) {
  Real cut = share > Real(0) ? Real(1) - min(share, Real(1)) : Real(1);
  Real turns = advance_turns(advance);
  Real p = turns_real(phase);
  if (!(turns > Real(1e-4)))
    return p > cut ? Real(2) * sin(Real(3.14159265358979324) * p) * sin(Real(3.14159265358979324) * p) : Real(0);
  Turns end = turns_add(phase, advance.part);
  Real whole = Real(advance.whole) + (turns_less(end, phase) ? Real(1) : Real(0));
  Real energy = whole * mains_energy(Real(1), cut) + mains_energy(turns_real(end), cut) - mains_energy(p, cut);
  return max(energy / turns, Real(0));
}

// LED: the driver follows its level like an RC circuit; the heat follows the power, and a hot LED gives less light.

struct LedType {
  Real rise_s;  // time constant of the driver, 0.001 to 0.005; 0: at once
  Real heat_s;  // time constant of the heat sink, minutes; 0: no droop
  Real droop;   // share of light lost when hot at full level, 0 to 0.3
};

struct Led {
  Real level;       // of the current, 0 to 1
  Real heat;        // 0 to 1: relative to the equilibrium at full level
  Real from_level;  // at the last change of the target
  Real from_heat;
  Real target;
  uint pad;
  Turns since_ns;  // time since that change
};

FL_FN Led led_start(Real level) {
  Led led;
  led.level = level;
  led.heat = Real(0);
  led.from_level = level;
  led.from_heat = Real(0);
  led.target = level;
  led.pad = uint(0);
  led.since_ns = turns_zero();
  return led;
}

// Returns the mean light over the step, 0 to 1; for dt_ns = 0 the current light. Exact, except that the droop at the
// end of the step is used for the whole step: off by at most droop * dt / heat_s. A target outside 0 to 1 is clamped;
// NaN is ignored.
FL_INLINE Real led_step(FL_INOUT(Led) led, LedType type, Real target, Turns dt_ns) {
  Real droop = type.heat_s >= Real(1e-6) && type.heat_s <= Real(1e6) ? unit_share(type.droop) : Real(0);
  if (!(abs(target) <= Real(1e9))) return led.level * (Real(1) - droop * led.heat);
  Real level = unit_share(target);
  if (level != led.target) {
    led.from_level = led.level;
    led.from_heat = led.heat;
    led.target = level;
    led.since_ns = turns_zero();
  }
  if (dt_ns == turns_zero()) return led.level * (Real(1) - droop * led.heat);
  Real before_s = time_s(led.since_ns);
  led.since_ns = time_add(led.since_ns, dt_ns);
  Real after_s = time_s(led.since_ns);
  Real off = led.from_level - level;
  Real mean = level;
  bool slow = type.rise_s >= Real(1e-6) && type.rise_s <= Real(1e6);
  if (slow) {
    Real begin = off != Real(0) ? (before_s > Real(0) ? decay_share(before_s / type.rise_s) : Real(1)) : Real(0);
    led.level = level;
    if (begin > Real(0)) {
      Real length = (after_s - before_s) / type.rise_s;
      Real share = relax_share(length);
      if (length > Real(0)) mean = level + off * begin * (share / length);
      led.level = level + off * (begin * (Real(1) - share));
    }
  } else {
    led.level = level;
  }
  if (type.heat_s >= Real(1e-6) && type.heat_s <= Real(1e6)) {
    // dheat/dt = (level(t) - heat) / heat_s, with level(t) = target + off exp(-t / rise_s).
    Real rate = Real(1) / type.heat_s;
    Real cooled = decay_share(after_s * rate);
    led.heat = level + (led.from_heat - level) * cooled;
    if (slow) {
      Real gap = Real(1) / type.rise_s - rate;  // difference of the two rates
      Real both = abs(gap) * after_s < Real(1e-3)
                      ? after_s * decay_share(after_s * Real(0.5) * (rate + Real(1) / type.rise_s))
                      : (cooled - decay_share(after_s / type.rise_s)) / gap;
      led.heat += off * rate * both;
    }
    led.heat = unit_share(led.heat);
  }
  return unit_share(mean) * (Real(1) - droop * led.heat);
}

// Discharge: an arc that strikes, runs up, and cannot strike while it is hot. Its dimmer is a dowser (slew_step).

struct DischargeType {
  Real ignite_s;       // from power on to the arc, cold
  Real run_up_s;       // time constant of the run-up; some 0.3 of the minutes that makers state
  Real cool_s;         // time constant of cooling
  Real restrike_warm;  // the arc can strike at this warmth and below, (0, 1)
  Real first_light;    // share of the light right after striking, 0 to 1
};

struct Discharge {
  Real warm;       // 0 cold to 1 after the run-up
  uint lit;        // 1: the arc burns
  Real from_warm;  // at the last switch of the power
  uint from_lit;
  uint power;  // 1: on
  uint pad;
  Turns since_ns;  // time since that switch
};

FL_FN Discharge discharge_start() {
  Discharge lamp;
  lamp.warm = Real(0);
  lamp.lit = uint(0);
  lamp.from_warm = Real(0);
  lamp.from_lit = uint(0);
  lamp.power = uint(0);
  lamp.pad = uint(0);
  lamp.since_ns = turns_zero();
  return lamp;
}

FL_FN Real discharge_share(Real t_s, Real tau_s) { return tau_s >= Real(1e-6) ? decay_share(t_s / tau_s) : Real(0); }

// Seconds from power on to the arc at a given warmth: the hot-restrike lockout, then the ignition.
FL_FN Real discharge_strike_s(Real warm, DischargeType type) {
  Real locked_s = Real(0);
  if (warm > type.restrike_warm && type.restrike_warm > Real(0) && type.cool_s > Real(0))
    locked_s = type.cool_s * log(warm / type.restrike_warm);
  return locked_s + (type.ignite_s > Real(0) ? type.ignite_s : Real(0));
}

// Mean light, between two times after the strike, of an arc that struck at `warm`.
FL_FN Real discharge_light(Real warm, DischargeType type, Real before_s, Real after_s) {
  Real first = unit_share(type.first_light);
  Real cold = (Real(1) - warm) * discharge_share(before_s, type.run_up_s);
  Real length = type.run_up_s >= Real(1e-6) ? (after_s - before_s) / type.run_up_s : Real(0);
  if (length > Real(0)) cold *= relax_share(length) / length;
  return Real(1) - (Real(1) - first) * cold;
}

// Returns the mean light over the step, 0 to 1; for dt_ns = 0 the current light.
FL_FN Real discharge_step(FL_INOUT(Discharge) lamp, DischargeType type, uint power, Turns dt_ns) {
  if (power != lamp.power) {
    lamp.from_warm = lamp.warm;
    lamp.from_lit = power == uint(0) ? uint(0) : lamp.lit;
    lamp.lit = lamp.from_lit;
    lamp.power = power;
    lamp.since_ns = turns_zero();
  }
  Real before_s = time_s(lamp.since_ns);
  lamp.since_ns = time_add(lamp.since_ns, dt_ns);
  Real after_s = time_s(lamp.since_ns);
  if (power == uint(0)) {
    lamp.warm = lamp.from_warm * discharge_share(after_s, type.cool_s);
    return Real(0);
  }
  Real strike_s = lamp.from_lit != uint(0) ? Real(0) : discharge_strike_s(lamp.from_warm, type);
  Real struck_warm =
      lamp.from_lit != uint(0) ? lamp.from_warm : lamp.from_warm * discharge_share(strike_s, type.cool_s);
  if (!(after_s >= strike_s)) {
    lamp.warm = lamp.from_warm * discharge_share(after_s, type.cool_s);
    return Real(0);
  }
  lamp.lit = uint(1);
  lamp.warm = Real(1) - (Real(1) - struck_warm) * discharge_share(after_s - strike_s, type.run_up_s);
  Real burns_s = min(after_s - before_s, after_s - strike_s);
  Real light = discharge_light(struck_warm, type, max(after_s - burns_s - strike_s, Real(0)), after_s - strike_s);
  return after_s > before_s ? light * (burns_s / (after_s - before_s)) : light;
}

// Colour temperature between that of a fresh arc and that after the run-up.
FL_FN Real discharge_kelvin(Discharge lamp, Real first_k, Real full_k) { return mix(first_k, full_k, lamp.warm); }
